/// What of each view of a walk is worth remembering: features that neighbouring views show too, so that what moves, or
/// is seen by chance, is no part of a place (Hua 3.3 and 4.1.3).

#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/features/icgm_sequence.h"
#include "algorithms/features/pirf.h"

namespace gaitcam {

enum class Robustness {
  kNone,  ///< Every feature.
  kPirf,  ///< Those found in each of the last few views.
  kIcgm,  ///< Those that ICGM keeps of the matches with the view before, or also with the one after.
};
constexpr auto WordsOf(Robustness) {
  return std::array{EnumWord{Robustness::kNone, "none"}, EnumWord{Robustness::kPirf, "pirf"},
                    EnumWord{Robustness::kIcgm, "icgm"}};
}

struct RobustViewOptions {
  using DescribedTag = void;
  Robustness robust = Robustness::kNone;
  PirfOptions pirf;
  RobustFeatureOptions icgm;

  static RobustViewOptions By(Robustness robust) {
    RobustViewOptions options;
    options.robust = robust;
    return options;
  }
};

template <class Visitor>
void VisitFields(Visitor& visit, RobustViewOptions& o) {
  visit("robust", o.robust, EnumWords<Robustness>(), "which features of a view are kept");
  visit("pirf", o.pirf, Nested(), "robust pirf");
  visit("icgm", o.icgm, Nested(), "robust icgm; where a system verifies loops by ICGM, also how");
}

struct RobustView {
  int64_t stamp_ns = 0;
  Features features;
};

class RobustViews {
 public:
  /// @throws BadOption.
  RobustViews(const RobustViewOptions& options, uint64_t seed);

  /// The next view of the film. @returns views that are ready now: this one, or the one that waited for it; those that
  /// have no neighbours yet show nothing. @throws BadInput if the size of images changes.
  std::vector<RobustView> Add(int64_t stamp_ns, FeatureImage view);
  /// Those that still wait: no later view will come.
  std::vector<RobustView> Finish();

 private:
  size_t Reach() const;
  RobustView Ready(size_t current);

  RobustViewOptions options_;
  RandomStream random_;
  std::deque<int64_t> stamps_;
  std::vector<FeatureImage> images_;  ///< The last ones, oldest first: as many as a view is compared with.
  size_t waiting_ = 0;                ///< Of the last images, those that are not ready.
};

}  // namespace gaitcam
