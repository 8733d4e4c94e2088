/// What a SLAM system says: one entry per frame it was given, lost or not.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/map.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

enum class TrackingStatus {
  kInitializing,  ///< No map yet, or another one is being started.
  kTracking,      ///< `pose` is set: the frame's own image supports it.
  kLost,          ///< The frame does not fit what is known; a pose said of it would be frozen or extrapolated.
};

/// "initializing", "tracking", "lost".
std::string ToString(TrackingStatus status);

/// The answer to one observation. The system chooses its world frame W and, if monocular, its scale.
struct FrameEstimate {
  int64_t stamp_ns = 0;
  TrackingStatus status = TrackingStatus::kInitializing;
  std::optional<Pose> pose;  ///< X_WC of the left camera, present exactly when tracking. A pose is a measurement.
  /// X_WC as the system expects it, where the frame's image supports no pose: frozen, extrapolated, or of the rotation
  /// alone. For whoever must act in the meantime; never beside `pose`, and never scored as one.
  std::optional<Pose> predicted;
  /// Of the pose, where the system knows it: of tau = (rho, phi) in X_WC Exp(tau), translation first (se3.h), so given
  /// in the camera's frame; (unit of the pose)^2, unit rad, rad^2. Never without a pose.
  std::optional<Matrix6d> covariance;
  /// The part of `covariance` that this frame's own measurements bring and no other frame shares; absent: unknown, or
  /// none. What two frames share cancels in the motion between them, and this does not. Never without `covariance`.
  std::optional<Matrix6d> own_covariance;
  /// 6 x m, what errors that stay the same over the whole run (of a calibration) do to the pose: a column for one
  /// standard deviation of each, in the same order in all frames. G G^T of it is a part of `covariance` as well. In the
  /// motion between two frames their difference counts. 6 x 0: none. Never without `own_covariance`.
  CommonErrors common_errors;
  /// The pose is of so much later than the frame's stamp: an external program stamps its poses as it likes.
  int64_t pose_delay_ns = 0;
  bool restarted = false;  ///< The system says that it chose W or its scale anew at this frame. No score depends on it.
  int features = 0;        ///< Found in this frame.
  int inliers = 0;         ///< Of those, agreeing with the pose.
  int matches = 0;         ///< Among which the robust estimator looked for inliers; 0: unknown.
};

/// What a system says at its end.
struct FinalEstimate {
  std::vector<FrameEstimate> frames;  ///< Those that it corrects, by their stamps; the others stand as they were given.
  std::vector<Map> maps;              ///< In the world of the poses; none of an odometry that keeps none.
  std::string failure;                ///< Why it stopped working, in one line; empty if it did not.
  bool keyframes_only = false;        ///< It gives poses of its key frames and of no others.
  bool saw_all_first = false;         ///< It answered nothing before it had seen the whole film: nothing was said live.
  std::vector<std::string> remarks;   ///< What was odd about the answers and was put right, a line each.
};

/// All answers of one run, in frame order.
///
/// A system answers twice: live, at each frame, when it has seen nothing later; and finally, after the last frame.
struct Estimate {
  std::vector<FrameEstimate> frames;  ///< The final answer: the last word on each frame.
  std::vector<FrameEstimate> live;    ///< The live answer to each frame; empty if there was none, or it is not known.
  std::vector<Map> maps;              ///< In the world of the poses.
  std::string failure;                ///< Why the system stopped working, in one line; empty if it did not.
  bool keyframes_only = false;        ///< Frames between key frames have no pose: coverage counts the key frames' span.
  std::vector<std::string> remarks;   ///< FinalEstimate::remarks.
  std::vector<double> track_ms;       ///< Wall time spent per frame; the one part that differs from run to run.

  /// The final answer's poses.
  Trajectory ToTrajectory() const;
};

/// The frames that have a pose, each pose at its own instant.
Trajectory PosesOf(const std::vector<FrameEstimate>& frames);

}  // namespace gaitcam
