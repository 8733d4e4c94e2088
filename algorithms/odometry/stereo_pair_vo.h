/// Stereo visual odometry from one frame to the next, with the covariance of each motion:
///   R. Valencia and J. Andrade-Cetto, "Mapping, Planning and Exploration with Pose SLAM", chapter 2
/// and nothing else. No landmarks, no keyframes, no refinement.
///
/// 1. Features of both images; their standard deviation is the scale at which they were found (section 2.3.1).
/// 2. Partners along epipolar lines, and matches of these with the frame before: four images.
/// 3. Points by least squares (Eq. 2.3).
/// 4. The motion that aligns both clouds best, in the sense of Eq. 2.4, by SVD (Eqs. 2.15 to 2.21) in RANSAC.
/// 5. Its covariance by error propagation (Eqs. 2.22 to 2.31). Motions are taken as independent, which they are not:
/// two
///    in turn share a frame.
///
/// Where a step fails the frame has no pose, and the next one begins at the last known pose.

#pragma once

#include <memory>
#include <string>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/matching.h"
#include "algorithms/odometry/frame_view.h"
#include "algorithms/odometry/stereo_view.h"

namespace gaitcam {

struct StereoPairVoOptions {
  using DescribedTag = void;

  std::string feature = "sift";  ///< Detector by name; SIFT is the chapter's.
  int max_features = 1000;       ///< Strongest features kept per image.
  double sensitivity = 3;        ///< The detector's own threshold is divided by this.
  StereoMatchingOptions stereo;  ///< Step 2. Fields of these are fields of these options.
  MatchingOptions matching;      ///< Step 2, between frames.
  double threshold_m = 0.05;     ///< Step 4: largest distance of two points that agree, m.
  int max_iterations = 500;      ///< Step 4: largest number of samples.
  int min_inliers = 12;          ///< With fewer the pair of frames has failed.
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoPairVoOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("max_features", o.max_features, Between(50, 100000), "strongest features kept per image");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  VisitFields(visit, o.stereo);
  VisitFields(visit, o.matching);
  visit("threshold_m", o.threshold_m, Between(1e-4, 100.0), "largest distance of two points that agree, m");
  visit("max_iterations", o.max_iterations, Between(1, 1000000), "largest number of samples");
  visit("min_inliers", o.min_inliers, Between(4, 100000), "with fewer inliers a pair of frames has failed");
}

class StereoPairVo {
 public:
  /// @throws BadInput if the rig cannot be used (StereoRig::Check); BadOption if an option is out of range.
  StereoPairVo(const Calibration& calibration, const StereoPairVoOptions& options, uint64_t seed);
  ~StereoPairVo();

  /// Answers one frame. The first is the world frame W. Failure is an answer without a pose, never an error.
  /// `restarted` marks the first pose after one.
  /// @throws BadInput if an image's size is not its camera's, or the first frame is no pair or swapped (stereo_view.h).
  FrameEstimate Track(const Observation& observation);

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace gaitcam
