/// SLAM by appearance alone: every view is a place, and a loop is closed where an earlier place is recognised (Hua 2.2
/// and 4.2). There are no poses; which memory of places is asked is what the systems differ in.

#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/features2d.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/places/pirf_nav.h"
#include "algorithms/places/place_memory.h"

namespace gaitcam {

struct AppearanceSlamOptions {
  using DescribedTag = void;
  std::string feature = "surf";
  int max_features = 300;
  double every_s = 1;
  double apart_s = 20;
};

template <class Visitor>
void VisitFields(Visitor& visit, AppearanceSlamOptions& o) {
  visit("feature", o.feature, AnyText(), "detector and descriptor of what places are known by");
  visit("max_features", o.max_features, Between(10, 100000), "of a view, the strongest");
  visit("every_s", o.every_s, Between(0.0, 1000.0), "time from one place to the next");
  visit("apart_s", o.apart_s, Between(0.0, 1e5), "places seen so shortly before are not taken for a loop");
}

/// Of system `pirf_nav`.
struct PirfNavSlamOptions {
  using DescribedTag = void;
  AppearanceSlamOptions views;
  PirfNavOptions memory;
};

template <class Visitor>
void VisitFields(Visitor& visit, PirfNavSlamOptions& o) {
  VisitFields(visit, o.views);
  VisitFields(visit, o.memory);
}

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
  AppearanceSlam(std::unique_ptr<PlaceMemory> memory, const AppearanceSlamOptions& options);

  /// A place has no pose: the estimate is empty, its status "initializing". @throws BadInput if the memory cannot be
  /// asked by these features.
  FrameEstimate Track(const Observation& observation);
  /// After the last frame: what each place takes.
  void Finish();
  /// A node and a test for each view, in the order of the film.
  const PlaceGraph& graph() const { return graph_; }
  /// Of each node, in their order: also answers that were not sure enough for a loop.
  const std::vector<AppearanceTest>& tests() const { return tests_; }

 private:
  size_t PlacesBefore(int64_t stamp_ns) const;

  std::unique_ptr<PlaceMemory> memory_;
  AppearanceSlamOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  PlaceGraph graph_;
  std::vector<AppearanceTest> tests_;
};

}  // namespace gaitcam
