/// SLAM by appearance alone: every view is a place, and a loop is closed where an earlier place is recognised (Hua 2.2
/// and 4.2). There are no poses; which memory of places is asked is what the systems differ in.

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/features2d.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/places/icgm_places.h"
#include "algorithms/places/pirf_nav.h"
#include "algorithms/places/place_memory.h"
#include "algorithms/slam/robust_views.h"

namespace gaitcam {

/// Of which views places are made.
struct ViewOptions {
  using DescribedTag = void;
  std::string feature = "surf";
  int max_features = 300;
  double every_s = 1;
  double apart_s = 20;
};

template <class Visitor>
void VisitFields(Visitor& visit, ViewOptions& o) {
  visit("feature", o.feature, AnyText(), "detector and descriptor of what places are known by");
  visit("max_features", o.max_features, Between(10, 100000), "of a view, the strongest");
  visit("every_s", o.every_s, Between(0.0, 1000.0), "time from one place to the next");
  visit("apart_s", o.apart_s, Between(0.0, 1e5), "places seen so shortly before are not taken for a loop");
}

/// Of a system that is made of such views and one memory.
template <class MemoryOptions, Robustness kRobustness>
struct AppearanceSlamOptions {
  using DescribedTag = void;
  ViewOptions views;
  RobustViewOptions robust = RobustViewOptions::By(kRobustness);
  MemoryOptions memory;
};

template <class Visitor, class MemoryOptions, Robustness kRobustness>
void VisitFields(Visitor& visit, AppearanceSlamOptions<MemoryOptions, kRobustness>& o) {
  VisitFields(visit, o.views);
  VisitFields(visit, o.robust);
  VisitFields(visit, o.memory);
}

using PirfNavSlamOptions = AppearanceSlamOptions<PirfNavOptions, Robustness::kPirf>;
using IcgmSlamOptions = AppearanceSlamOptions<IcgmPlacesOptions, Robustness::kIcgm>;

/// What was asked of a view, and answered.
struct AppearanceTest {
  int64_t stamp_ns = 0;
  int first_places = 0;  ///< Those that could be the answer.
  int place = -1;        ///< As in PlaceAnswer, as are the next two; -1: none.
  bool known = false;
  double confidence = 0;
};

class AppearanceSlam {
 public:
  /// @throws BadOption; BadInput for an unknown feature.
  AppearanceSlam(std::unique_ptr<PlaceMemory> memory, const ViewOptions& options, const RobustViewOptions& robust,
                 uint64_t seed);
  /// PIRF-nav 2.0, and Hua's own. @throws as above.
  AppearanceSlam(const PirfNavSlamOptions& options, uint64_t seed);
  AppearanceSlam(const IcgmSlamOptions& options, uint64_t seed);

  /// A place has no pose: the estimate is empty, its status "initializing". @throws BadInput if the memory cannot be
  /// asked by these features.
  FrameEstimate Track(const Observation& observation);
  /// After the last frame: views that waited for the next one, and what each place takes.
  void Finish();
  /// The film ends here, and another begins. Its views are asked about and not remembered: the answer may be any place
  /// of the film before, and tests() goes on where the graph does not.
  void StopLearning();
  /// A node and a test for each view, in the order of the film.
  const PlaceGraph& graph() const { return graph_; }
  /// Of each node, in their order, and then of each view since StopLearning(): also answers that were not sure enough
  /// for a loop.
  const std::vector<AppearanceTest>& tests() const { return tests_; }

 private:
  size_t PlacesBefore(int64_t stamp_ns) const;
  void Visit(const RobustView& view);

  std::unique_ptr<PlaceMemory> memory_;
  ViewOptions options_;
  RobustViewOptions robust_options_;
  uint64_t seed_;
  RobustViews robust_;
  std::map<int64_t, cv::Mat> pictures_;  ///< Of views that are not ready, by stamp.
  bool learns_ = true;
  cv::Ptr<cv::Feature2D> detector_;
  std::optional<int64_t> last_ns_;  ///< The last frame that was taken for a view.
  PlaceGraph graph_;
  std::vector<AppearanceTest> tests_;
};

}  // namespace gaitcam
