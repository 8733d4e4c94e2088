#include "scenarios/code/runs/handicap.h"

#include <fmt/format.h>

#include <cmath>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {

bool IsHandicap(const HandicapOptions& o) {
  return o.pose_noise > 0 || o.pose_noise_deg > 0 || o.drop_every > 0 || o.focal_factor != 1 || o.late_ms != 0 ||
         o.scale_factor != 1 || o.yaw_deg_per_m != 0 || o.jump > 0 || o.garbage_every > 0 || o.crash_at_frame > 0;
}

Calibration FalsifiedCalibration(Calibration calibration, const HandicapOptions& options) {
  const auto falsify = [&](CameraModel& camera) {
    camera.fx *= options.focal_factor;
    camera.fy *= options.focal_factor;
  };
  falsify(calibration.camera);
  if (calibration.right) falsify(*calibration.right);
  return calibration;
}

HandicappedSystem::HandicappedSystem(std::unique_ptr<System> system, const HandicapOptions& options, uint64_t seed)
    : system_(std::move(system)),
      options_(options),
      random_(seed, "handicap"),
      is_garbage_(options.garbage_every > 0 && seed % uint64_t(options.garbage_every) == 0) {}

FrameEstimate HandicappedSystem::Track(const Observation& observation) {
  ++frame_;
  if (options_.crash_at_frame > 0 && frame_ >= options_.crash_at_frame) {
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = had_pose_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    return answer;
  }
  Observation seen = observation;
  seen.imu.insert(seen.imu.begin(), imu_.begin(), imu_.end());
  seen.joints.insert(seen.joints.begin(), joints_.begin(), joints_.end());
  seen.odometry.insert(seen.odometry.begin(), odometry_.begin(), odometry_.end());
  if (options_.drop_every > 0 && frame_ % options_.drop_every == 0) {
    imu_ = std::move(seen.imu);
    joints_ = std::move(seen.joints);
    odometry_ = std::move(seen.odometry);
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = had_pose_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    return answer;
  }
  imu_.clear();
  joints_.clear();
  odometry_.clear();
  FrameEstimate answer = system_->Track(seen);
  had_pose_ |= answer.pose.has_value();
  Spoil(answer, live_);
  return answer;
}

FinalEstimate HandicappedSystem::Finish() {
  FinalEstimate answer = system_->Finish();
  Spoiler spoiler;
  for (FrameEstimate& frame : answer.frames) Spoil(frame, spoiler);
  if (options_.crash_at_frame > 0 && frame_ >= options_.crash_at_frame) {
    answer.failure = fmt::format("stopped on purpose at frame {} (handicap.crash_at_frame)", options_.crash_at_frame);
  }
  return answer;
}

Pose HandicappedSystem::Bend(const Pose& pose, Spoiler& spoiler) const {
  const Pose step = spoiler.before ? spoiler.before->Inverse() * pose : Pose();
  const double yaw_rad = options_.yaw_deg_per_m * kRadPerDeg * step.translation.norm();
  const Pose turn(ExpSo3({0, yaw_rad, 0}), {0, 0, 0});  // a camera's y points down
  const Pose bent = spoiler.bent ? *spoiler.bent * step * turn : pose;
  spoiler.before = pose;
  spoiler.bent = bent;
  return bent;
}

void HandicappedSystem::Spoil(FrameEstimate& frame, Spoiler& spoiler) {
  constexpr int kJumpsAt = 20;
  if (!frame.pose) return;
  if (options_.yaw_deg_per_m != 0) frame.pose = Bend(*frame.pose, spoiler);
  if (++spoiler.poses >= kJumpsAt) frame.pose->translation.x() += options_.jump;
  frame.pose->translation *= options_.scale_factor;
  frame.pose_delay_ns += std::llround(1e6 * options_.late_ms);
  const auto draw = [this] { return Eigen::Vector3d(random_.Normal(), random_.Normal(), random_.Normal()); };
  if (is_garbage_) *frame.pose = Pose(ExpSo3(draw()), 100 * draw());
  if (options_.pose_noise > 0) frame.pose->translation += options_.pose_noise * draw();
  if (options_.pose_noise_deg > 0) {
    frame.pose->rotation = frame.pose->rotation * ExpSo3(options_.pose_noise_deg * kRadPerDeg * draw());
  }
}

}  // namespace gaitcam
