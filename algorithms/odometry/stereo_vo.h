/// Stereo visual odometry that says how wrong it is: landmarks by triangulation, every frame localised against them by
/// maximum likelihood, keyframes refined in a window by bundle adjustment, and a covariance with every pose.
///
/// Composed of
/// - StereoView: features of both images, matched along epipolar lines of the unrectified rig;
/// - KeypointNoise: a covariance of every feature, by its scale and the blur;
/// - ExposureMotion: the camera's path over the exposure, a rolling shutter's readout and since the last frame, by an
///   IMU where there is one;
/// - StereoMap: keyframes and landmarks, and their adjustment, with the rig's rotation as an unknown;
/// - RefineRigPose (algorithms/geometry/rig_pose.h): a frame's pose, and what its error is made of;
/// - KeyframePolicy: a robot that stands adds none, and does not drift.
///
/// A pose's covariance has two parts. One comes with the map: it grows from keyframe to keyframe, by what the window's
/// adjustment says, and frames near each other share it. The other, `own_covariance`, is the frame's own: its images'
/// errors, that of landmarks which its neighbour does not use, and what is not known of the motion while the shutter
/// was open, and rolled. Beside them stands what a lens that is calibrated a little wrong does to all frames alike, as
/// far as the calibration says how wrong it may be (algorithms/geometry/lens_errors.h). Source of the idea, and of the
/// method without a map: Valencia, chapter 2.
///
/// The world frame W is the first keyframe's left camera. No loop closure.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/odometry/frame_view.h"
#include "algorithms/odometry/keyframe_policy.h"
#include "algorithms/odometry/keypoint_noise.h"
#include "algorithms/odometry/stereo_map.h"
#include "algorithms/odometry/stereo_view.h"

namespace gaitcam {

struct StereoVoOptions {
  using DescribedTag = void;

  std::string feature = "sift";  ///< Detector by name (algorithms/features/features.h).
  int max_features = 1000;       ///< Strongest features kept per image.
  double sensitivity = 3;        ///< The detector's own threshold is divided by this.

  // The fields of these are fields of these options.
  KeypointNoiseOptions noise;
  StereoMatchingOptions stereo;
  KeyframePolicyOptions policy;

  double ratio = 0.85;             ///< Nearest over second nearest descriptor distance of a landmark's candidates.
  double predicted_px = 10;        ///< Radius in which a landmark is searched for first where an IMU predicts the pose.
  double search_px = 60;           ///< The same without one, or else.
  double narrow_px = 6;            ///< And again, from the pose found.
  double outlier_sigmas = 3.5;     ///< Largest Mahalanobis distance of an inlier.
  int min_inliers = 15;            ///< With fewer a frame has no pose.
  int window = 12;                 ///< Keyframes refined together.
  int adjust_iterations = 8;       ///< Largest number of iterations of one adjustment.
  double rig_rotation_deg = 0.05;  ///< Standard deviation of the right camera's rotation as calibrated; 0: exact.
  bool use_imu = true;             ///< Use the IMU where there is one.
  bool shutter_by_imu = true;      ///< Undo a rolling shutter by it (ExposureMotion::ReadoutPath).
  int max_lost_frames = 15;        ///< Frames without a pose after which the map is begun anew.
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoVoOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("max_features", o.max_features, Between(50, 100000), "strongest features kept per image");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  VisitFields(visit, o.noise);
  VisitFields(visit, o.stereo);
  VisitFields(visit, o.policy);
  visit("ratio", o.ratio, Between(0.1, 1.0), "ratio test: nearest over second nearest descriptor distance");
  visit("predicted_px", o.predicted_px, Between(1.0, 10000.0), "search radius where an IMU predicts the pose, px");
  visit("search_px", o.search_px, Between(1.0, 10000.0), "search radius around a landmark's prediction, px");
  visit("narrow_px", o.narrow_px, Between(0.5, 1000.0), "the same from the pose found, px");
  visit("outlier_sigmas", o.outlier_sigmas, Between(1.0, 100.0), "largest Mahalanobis distance of an inlier");
  visit("min_inliers", o.min_inliers, Between(6, 100000), "with fewer inliers a frame has no pose");
  visit("window", o.window, Between(2, 1000), "keyframes refined together by bundle adjustment");
  visit("adjust_iterations", o.adjust_iterations, Between(1, 1000), "largest number of iterations of an adjustment");
  visit("rig_rotation_deg", o.rig_rotation_deg, Between(0.0, 10.0),
        "1 sigma of the right camera's rotation as calibrated, about each axis; 0: exact, else it is refined");
  visit("use_imu", o.use_imu, Nested(), "use the IMU where there is one");
  visit("shutter_by_imu", o.shutter_by_imu, Nested(), "correct a rolling shutter by the IMU, where there is one");
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "frames without a pose until a new map");
}

class StereoVo {
 public:
  /// @throws BadInput if the rig cannot be used (StereoRig::Check); BadOption if an option is out of range.
  StereoVo(const Calibration& calibration, const StereoVoOptions& options, uint64_t seed);
  ~StereoVo();

  /// Answers one frame. Where the images show too little, the answer has no pose: "initializing" before the first one,
  /// then "lost", with the last known pose as `predicted`. After `max_lost_frames` of these a new map begins at the
  /// last known pose, marked `restarted`. A frame whose right image is missing, or of another instant, is lost too.
  /// @throws BadInput if an image's size is not its camera's; if the first frame has no right image, or one of another
  /// instant; or if left and right are swapped.
  FrameEstimate Track(const Observation& observation);

  /// The final estimate: every frame once more against the landmarks as they were refined later.
  std::vector<FrameEstimate> Finish();

  /// How the right camera stands to the left one, as refined so far.
  Pose X_LR() const;

  /// Keyframes and landmarks. Keyframes within the window still move.
  const StereoMap& map() const;
  /// The frame tracked last, if it became a keyframe: map().keyframes().back(). Else null.
  const StereoView* keyframe_view() const;

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
