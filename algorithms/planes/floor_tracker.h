/// A camera's trajectory over a flat floor, from the pixels of the floor: each frame is aligned with a keyframe (thesis
/// 6.4), whose plane is known from how the camera is carried and is refined by every frame.
///
/// World W: z = 0 is the floor, z up, the origin below the first camera, x along its view; m, by the height at which
/// the calibration says that the camera stands.

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/gyro_turn.h"
#include "algorithms/geometry/up_direction.h"
#include "algorithms/odometry/exposure_motion.h"
#include "algorithms/planes/floor_keyframe.h"
#include "algorithms/planes/undistortion.h"

namespace gaitcam {

struct FloorTrackerOptions {
  using DescribedTag = void;

  PlaneAlignmentOptions alignment;
  FloorRegionOptions regions;
  double range_heights = 6;            ///< Floor beyond this distance, in camera heights, is not used.
  double keyframe_move_heights = 0.4;  ///< A keyframe is made after a translation by so many camera heights ...
  double keyframe_turn_deg = 12;       ///< ... or a rotation by so much ...
  double keyframe_inside_ratio = 0.6;  ///< ... or when a smaller part of the last one's points is in view.
  double min_correlation = 0.8;        ///< Of a frame with the keyframe.
  int max_lost_frames = 3;             ///< In a row, before the tracker restarts with a new keyframe.
  double max_height_ratio = 0.2;       ///< Camera height off the standing one, relative.
  double max_tilt_deg = 10;            ///< Between the camera's up direction and gravity's or the standing one.
  double max_turn_deg = 0.5;           ///< Between rotation since the keyframe and the gyroscope's.
  double min_floor_ratio = 0.5;        ///< Of a keyframe's textured area that is floor.
  int min_points = 150;                ///< Textured pixels of a keyframe.
  double height_sigma_ratio = 0.03;    ///< Of a walking camera's height about the standing one's.
  double height_gain = 0.3;            ///< Part of the height's difference from standing corrected per keyframe.
  double tilt_sigma_deg = 0.15;        ///< Of a new keyframe's plane.
  double tilt_gain = 0.01;             ///< Part of the tilt's difference from gravity's corrected per keyframe.
  bool use_imu = true;                 ///< Rotation by the gyroscope, up by the accelerometer, where there is an IMU.
  /// Correct a rolling shutter: rotation within a readout by the gyroscope (ShutterTurn), translation over the floor by
  /// the poses before and the accelerometer (ExposureMotion). Needs `use_imu`; without an IMU images stay as they are.
  bool shutter_by_imu = true;
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
  visit("shutter_by_imu", o.shutter_by_imu, Nested(), "correct a rolling shutter by the gyroscope, where there is one");
}

/// What the tracker knows of its pose.
enum class FloorTrackerState {
  kInitializing,         ///< No frame has had enough texture: there is no keyframe.
  kTracking,             ///< The last frame is aligned with a keyframe that shows floor.
  kPredicting,           ///< The keyframe shows floor, but the last frames, max_lost_frames at most, are not aligned.
  kRestarted,            ///< The last frame became a keyframe at a guessed pose; it may show anything.
  kTentative,            ///< The last frame is aligned with such a keyframe.
  kTentativePredicting,  ///< As kPredicting, with such a keyframe.
};

/// What becomes of a frame.
enum class FloorTrackerEvent {
  kAligned,    ///< It is aligned with the keyframe, or is the first one.
  kSucceeded,  ///< Besides, it is the next keyframe: the regions of the last one proved to be floor.
  kMissed,     ///< It is not aligned; the keyframe is kept.
  kLost,       ///< It is not aligned, one frame too many: it becomes a keyframe at a guessed pose.
  kNotFloor,   ///< The regions of the keyframe that it is aligned with proved to be no floor: likewise.
};

/// A row per state, a column per event, in the order of the enums. kInitializing sees kAligned and kMissed only,
/// kRestarted all but kMissed.
inline constexpr std::array<std::array<FloorTrackerState, 5>, 6> kFloorTrackerTransitions = [] {
  using enum FloorTrackerState;
  return std::array<std::array<FloorTrackerState, 5>, 6>{{
      // kAligned, kSucceeded, kMissed, kLost, kNotFloor
      {kTracking, kInitializing, kInitializing, kInitializing, kInitializing},  // kInitializing
      {kTracking, kTracking, kPredicting, kRestarted, kRestarted},              // kTracking
      {kTracking, kTracking, kPredicting, kRestarted, kRestarted},              // kPredicting
      {kTentative, kTracking, kRestarted, kRestarted, kRestarted},              // kRestarted
      {kTentative, kTracking, kTentativePredicting, kRestarted, kRestarted},    // kTentative
      {kTentative, kTracking, kTentativePredicting, kRestarted, kRestarted},    // kTentativePredicting
  }};
}();

constexpr FloorTrackerState NextState(FloorTrackerState state, FloorTrackerEvent event) {
  return kFloorTrackerTransitions[size_t(state)][size_t(event)];
}

/// The keyframe is known to show floor.
constexpr bool ShowsFloor(FloorTrackerState state) {
  return state == FloorTrackerState::kTracking || state == FloorTrackerState::kPredicting;
}

/// The result for one frame.
struct FloorTrack {
  bool tracked = false;    ///< Aligned with a keyframe that shows floor.
  bool tentative = false;  ///< Aligned with a keyframe made after a loss, not known to show floor before this frame.
  int keyframe = 0;        ///< Which it was aligned with: FloorKeyframe::id.
  bool restarted = false;  ///< The first one aligned after a loss: the motion since the frame tracked last is a guess.
  Pose X_WC;               ///< Dead reckoning; where not aligned, a prediction.
  int points = 0;          ///< Pixels compared.
  int inliers = 0;
  /// Of the position (m) and yaw (rad) of the frame below the camera, in itself, since its keyframe.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double blur_px = 0;                    ///< Length of its motion blur in the middle of the image.
  std::optional<FloorKeyframe> retired;  ///< The keyframe that this frame succeeds, or that was given up with it.
};

class FloorTracker {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands.
  FloorTracker(const Calibration& calibration, const FloorTrackerOptions& options);

  /// @throws BadInput if the image's size is not the camera's.
  FloorTrack Track(const Observation& observation);

  /// After the last frame: the present keyframe, if it shows floor and any frame was aligned with it.
  std::optional<FloorKeyframe> Finish() const;

  FloorTrackerState state() const { return state_; }
  /// Of undistorted images.
  const CameraModel& camera() const { return undistortion_.camera(); }

 private:
  /// Rotation vectors of the camera in its own frame, where a gyroscope measured them.
  struct Turn {
    std::optional<Eigen::Vector3d> since_last, during_exposure;
  };
  /// A frame's alignment with the keyframe, and what led to it.
  struct Attempt {
    Pose predicted;  ///< X_WC
    CurrentBlur blur;
    PlaneAlignment alignment;
  };
  using Event = FloorTrackerEvent;

  Turn Integrate(const Observation& observation);
  void FollowGravity(const Observation& observation, const Turn& turn);
  const Eigen::Vector3d& UpC() const;

  Event Initialize(const Observation& observation, FloorTrack& track);
  Event Follow(const Observation& observation, const Turn& turn, FloorTrack& track, cv::Mat& rejected);
  Event Succeed(const Observation& observation, const Attempt& attempt, FloorTrack& track, cv::Mat& rejected);
  void Restart(const Observation& observation, const cv::Mat& rejected, FloorTrack& track);

  SeenAtRow RollingShutter(const Observation& observation) const;
  void TurnOn(const Observation& observation, const Turn& turn);
  Attempt Align(const Observation& observation, const Turn& turn) const;
  FloorTrack Described(const Attempt& attempt) const;
  bool IsPlausible(const Attempt& attempt, const FloorTrack& track) const;
  bool IsDue(const FloorTrack& track, double inside_ratio) const;
  void MakeKeyframe(int64_t stamp_ns, const Pose& X_WC, const BlurMotion& blur, const cv::Mat& rejected);
  Pose Corrected(const Pose& X_WC) const;

  Calibration calibration_;
  FloorTrackerOptions options_;
  Undistortion undistortion_;
  PlaneAligner aligner_;
  std::optional<GyroTurn> gyro_;        ///< Of robots with an IMU, as is ...
  std::optional<UpDirection> gravity_;  ///< ... this, while the gyroscope measures without a gap.
  ExposureMotion motion_;               ///< Since the last loss.

  FloorTrackerState state_ = FloorTrackerState::kInitializing;
  std::optional<FloorReference> keyframe_;
  int keyframes_ = 0;

  cv::Mat grey_;        ///< The present frame, undistorted ...
  ImagePyramid image_;  ///< ... and as alignment compares it.
  Pose X_WC_, X_last_;  ///< Of the last frame; its motion from the one before, X_(before)(last).
  Pose X_WC_dead_;      ///< Of the frame tracked last, rotated by the gyroscope since.
  int64_t last_ns_ = 0, tracked_ns_ = 0;
};

}  // namespace gaitcam
