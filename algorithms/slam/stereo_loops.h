/// Loop closures of a stereo rig: what is kept of a keyframe so that it can be matched with a later one, which of them
/// look like the present one, and the motion between two such frames by descriptors and geometry alone.

#pragma once

#include <Eigen/Core>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/lens_errors.h"
#include "algorithms/geometry/stereo_reconstruction.h"
#include "algorithms/odometry/stereo_view.h"
#include "algorithms/places/incremental_dictionary.h"

namespace gaitcam {

struct StereoLoopOptions {
  using DescribedTag = void;

  double loop_ratio = 0.8;      ///< Nearest over second nearest descriptor distance.
  int loop_inliers = 30;        ///< Fewer points that agree with one motion are no loop.
  double loop_inlier_pct = 25;  ///< Nor is a smaller part of the matches.
  double word_radius = 0.4;     ///< Of a word, in lengths of a descriptor; of binary ones, in parts of their bits.
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoLoopOptions& o) {
  visit("loop_ratio", o.loop_ratio, Between(0.1, 1.0), "ratio test between two keyframes");
  visit("loop_inliers", o.loop_inliers, Between(6, 100000), "points that must agree with one motion");
  visit("loop_inlier_pct", o.loop_inlier_pct, Between(0, 100), "... and which part of the matches");
  visit("word_radius", o.word_radius, Between(0.001, 2),
        "features so near to each other are one word (by which keyframes look alike)");
}

/// X_FT, from a kept frame to the present one.
struct LoopMotion {
  Pose X_FT;
  Matrix6d covariance;
  LensErrors lens_errors = LensErrors::Zero();  ///< Of X_FT, beside its covariance.
  int inliers = 0, matches = 0;
};

class StereoLoops {
 public:
  /// @param lens how wrong the lenses' calibration may be.
  StereoLoops(const StereoLoopOptions& options, const LensUncertainty& lens, uint64_t seed);

  /// Keeps the points that a keyframe's two images show, and their descriptors.
  void Keep(int keyframe, const StereoView& view, const StereoRig& rig);
  void Drop(int keyframe) { kept_.erase(keyframe); }

  /// How much each kept keyframe looks like the one kept last: over the words that both show, the sum of how rare they
  /// are (IncrementalDictionary::Score). Neither geometry nor pose is in it.
  std::map<int, double> LikeLast() const;

  /// The motion from a kept keyframe to a view, if the two show the same. @param guess of X_FT, one hypothesis of many.
  std::optional<LoopMotion> Match(int keyframe, const StereoView& view, const StereoRig& rig, const Pose& guess);

 private:
  struct Points {
    std::vector<RigSighting> seen;  ///< In the keyframe's frame F.
    cv::Mat descriptors;
    size_t place = 0;  ///< In the dictionary.
  };
  void LearnWords(const cv::Mat& descriptors);
  LensErrors LensErrorsOf(const std::vector<RigSighting>& in_F, const std::vector<RigSighting>& in_T,
                          const RigPoseResult& motion, const StereoRig& rig) const;

  StereoLoopOptions options_;
  LensUncertainty lens_;
  RandomStream random_;
  std::map<int, Points> kept_;
  std::optional<IncrementalDictionary> dictionary_;  ///< From the first keyframe on.
  WordSet last_words_;
};

}  // namespace gaitcam
