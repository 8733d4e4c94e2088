/// A camera's way over a flat floor, from the pixels of the floor: each frame is aligned with a keyframe (thesis 6.4),
/// whose plane is known from how the camera is carried and gets better with every frame.
///
/// World W: z = 0 is the floor, z up, the origin below the first camera, x along its view. Metric, by the height at
/// which the standing camera is said to be.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/geometry/up_direction.h"
#include "algorithms/planes/floor_regions.h"
#include "algorithms/planes/plane_alignment.h"

namespace gaitcam {

struct FloorTrackerOptions {
  using DescribedTag = void;

  PlaneAlignmentOptions alignment;
  FloorRegionOptions regions;
  double range_heights = 6;            ///< Floor farther away than so many camera heights is not used.
  double keyframe_move_heights = 0.4;  ///< A keyframe is made after a move by so many camera heights ...
  double keyframe_turn_deg = 12;       ///< ... or a turn by so much ...
  double keyframe_inside_ratio = 0.6;  ///< ... or when less of the last one is still in view.
  double min_correlation = 0.8;        ///< With the keyframe; less: the frame is lost.
  int max_lost_frames = 3;             ///< Then a new keyframe is tried.
  double max_height_ratio = 0.2;       ///< A camera this much higher or lower than standing is lost ...
  double max_tilt_deg = 10;            ///< ... or one that leans so from what gravity, or standing upright, says ...
  double max_turn_deg = 0.5;           ///< ... or one that turned otherwise than the gyroscope says ...
  double min_floor_ratio = 0.5;        ///< ... or whose view is floor to a smaller part.
  int min_points = 150;                ///< Pixels with texture that a keyframe needs.
  double height_sigma_ratio = 0.03;    ///< Of a walking camera's height about the standing one's.
  double height_gain = 0.3;            ///< Part of the height's difference from standing taken back per keyframe.
  double tilt_sigma_deg = 0.15;        ///< Of a new keyframe's plane.
  double tilt_gain = 0.01;             ///< Part of the tilt's difference from gravity's taken back per keyframe.
  bool use_imu = true;                 ///< Turn by the gyroscope, up by the accelerometer, where there is one.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorTrackerOptions& o) {
  visit("alignment", o.alignment, Nested(), "direct alignment with the keyframe");
  visit("regions", o.regions, Nested(), "which parts of the image lie on the floor");
  visit("range_heights", o.range_heights, Between(1.5, 100.0), "farthest floor used, in camera heights");
  visit("keyframe_move_heights", o.keyframe_move_heights, Between(0.01, 10.0), "move that makes a keyframe");
  visit("keyframe_turn_deg", o.keyframe_turn_deg, Between(0.1, 90.0), "turn that makes a keyframe");
  visit("keyframe_inside_ratio", o.keyframe_inside_ratio, Between(0.0, 1.0),
        "a smaller part of the last keyframe in view makes a new one");
  visit("min_correlation", o.min_correlation, Between(0.0, 1.0), "with the keyframe; less: lost");
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "lost frames until a new keyframe is tried");
  visit("max_height_ratio", o.max_height_ratio, Between(0.01, 10.0), "higher or lower than standing: lost");
  visit("max_tilt_deg", o.max_tilt_deg, Between(0.1, 90.0), "from what gravity or standing upright says: lost");
  visit("max_turn_deg", o.max_turn_deg, Between(0.01, 180.0), "since the keyframe, from what the gyroscope says: lost");
  visit("min_floor_ratio", o.min_floor_ratio, Between(0.0, 1.0), "a smaller part of what is seen is floor: lost");
  visit("min_points", o.min_points, Between(30, 100000), "textured pixels that a keyframe needs");
  visit("height_sigma_ratio", o.height_sigma_ratio, Between(1e-6, 1.0), "of a walking camera's height");
  visit("height_gain", o.height_gain, Between(0.0, 1.0), "part of the difference from standing taken back");
  visit("tilt_sigma_deg", o.tilt_sigma_deg, Between(0.001, 45.0), "of a new keyframe's plane");
  visit("tilt_gain", o.tilt_gain, Between(0.0, 1.0), "part of the difference from gravity taken back");
  visit("use_imu", o.use_imu, Nested(), "turn by the gyroscope, up by the accelerometer");
}

/// A keyframe that has served: what it shows of the floor is known now.
struct FloorKeyframe {
  int id = 0;
  int64_t stamp_ns = 0;
  ImagePyramid image;  ///< Undistorted, as the camera shows it.
  cv::Mat floor;       ///< CV_8UC1: not zero where it shows floor.
  Pose X_WK;
  /// Of the position (m) and yaw (rad) of the frame below the camera, in itself, since the keyframe before.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<FloorRegion> regions;
};

/// What one frame says.
struct FloorTrack {
  bool tracked = false;
  /// It was aligned, but with a keyframe made after a loss, which may have shown anything. It did show floor if it
  /// retires later; until then the frame is not `tracked`.
  bool tentative = false;
  int keyframe = 0;        ///< Which it was aligned with: FloorKeyframe::id.
  bool restarted = false;  ///< A new reference after the old one was lost: the motion in between is a guess.
  Pose X_WC;               ///< Dead reckoning; where not tracked, a prediction.
  int points = 0;          ///< Pixels compared.
  int inliers = 0;
  /// Of the position (m) and yaw (rad) of the frame below the camera, in itself, since its keyframe.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double blur_px = 0;                    ///< Length of its motion blur in the middle of the image.
  std::optional<FloorKeyframe> retired;  ///< The keyframe that this frame was tracked by, if this one succeeds it.
};

class FloorTracker {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands.
  FloorTracker(const Calibration& calibration, const FloorTrackerOptions& options);

  /// @throws BadInput if the image's size is not the camera's.
  FloorTrack Track(const Observation& observation);

  /// After the last frame: the keyframe that still serves, if any frame was tracked by it.
  std::optional<FloorKeyframe> Finish();

  /// Of undistorted images.
  const CameraModel& camera() const { return camera_; }

 private:
  struct Keyframe {
    PlaneReference reference;
    cv::Mat grey;  ///< Undistorted, as the camera shows it.
    std::vector<PutativePlane> regions;
    cv::Mat mask;      ///< Where it is compared.
    PlaneState plane;  ///< Its normal.
    Pose X_WK;
    int64_t stamp_ns = 0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of its way from the one before.
    int id = 0;
    bool confirmed = true;  ///< False after a loss, until the next one succeeds it.
    int tracked_frames = 0;
    std::optional<Eigen::Quaterniond> turned = Eigen::Quaterniond::Identity();  ///< R_KC since, by the gyroscope ...
    double turned_s = 0;                                                        ///< ... over this time.
  };
  struct Rotation {
    std::optional<Eigen::Vector3d> since_last, during_exposure;  ///< Rotation vectors of the camera in its own frame.
  };

  cv::Mat Undistort(const cv::Mat& image) const;
  Eigen::Vector3d AngularRate(const ImuSample& sample) const;
  void LearnBias(const Pose& X_CK);
  Rotation Integrate(const Observation& observation);
  void FollowGravity(const Observation& observation);
  const Eigen::Vector3d& UpC() const;
  void Start(const Observation& observation);
  void Restart(const Observation& observation, const Pose& X_WC, const cv::Mat& rejected);
  FloorTrack Follow(const Observation& observation, const Rotation& turned);
  void Succeed(const Observation& observation, const PlaneState& now, const CurrentBlur& blur, FloorTrack& track);
  FloorTrack Accept(const PlaneAlignment& found, const CurrentBlur& blur) const;
  bool IsPlausible(const FloorTrack& track) const;
  bool TurnsAsFelt(const Pose& X_CR) const;
  bool IsDue(const FloorTrack& track, double inside_ratio) const;
  FloorKeyframe Retire(const PlaneState* now, const CurrentBlur& blur) const;
  cv::Mat CarryRejected(const FloorKeyframe& retired, const PlaneState& now) const;
  void MakeKeyframe(int64_t stamp_ns, const Pose& X_WC, const ExposureMotion& blur, const cv::Mat& rejected);
  cv::Mat FloorMask(const Pose& X_WC) const;
  Pose Corrected(const Pose& X_WC) const;

  Calibration calibration_;
  FloorTrackerOptions options_;
  CameraModel camera_;
  PlaneAligner aligner_;
  cv::Mat map_u_, map_v_;  ///< Of cv::remap; empty if nothing is distorted.
  std::optional<Keyframe> keyframe_;
  ImagePyramid image_;
  cv::Mat grey_;
  Pose X_dead_;         ///< The last frame that was tracked, turned on by the gyroscope since.
  Pose X_WC_, X_last_;  ///< Of the last frame; its motion from the one before it (X of points).
  int64_t last_ns_ = 0, tracked_ns_ = 0;
  int lost_frames_ = 0, keyframes_ = 0;
  cv::Mat rejected_;  ///< Where what was followed in place of floor is now; empty if nothing was.
  std::vector<ImuSample> imu_;
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();  ///< In the camera's frame, rad/s.
  double gyro_bias_sigma_ = 0.02;                        ///< Of each component.
  std::optional<UpDirection> gravity_;                   ///< Of robots with an IMU.
};

}  // namespace gaitcam
