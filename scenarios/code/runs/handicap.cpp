#include "scenarios/code/runs/handicap.h"

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {

bool IsHandicap(const HandicapOptions& o) {
  return o.pose_noise > 0 || o.pose_noise_deg > 0 || o.drop_every > 0 || o.focal_factor != 1;
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
    : system_(std::move(system)), options_(options), random_(seed, "handicap") {}

FrameEstimate HandicappedSystem::Track(const Observation& observation) {
  ++frame_;
  Observation seen = observation;
  seen.imu.insert(seen.imu.begin(), imu_.begin(), imu_.end());
  seen.joints.insert(seen.joints.begin(), joints_.begin(), joints_.end());
  if (options_.drop_every > 0 && frame_ % options_.drop_every == 0) {
    imu_ = std::move(seen.imu);
    joints_ = std::move(seen.joints);
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = had_pose_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    return answer;
  }
  imu_.clear();
  joints_.clear();
  FrameEstimate answer = system_->Track(seen);
  had_pose_ |= answer.pose.has_value();
  Disturb(answer);
  return answer;
}

FinalEstimate HandicappedSystem::Finish() {
  FinalEstimate answer = system_->Finish();
  for (FrameEstimate& frame : answer.frames) Disturb(frame);
  return answer;
}

void HandicappedSystem::Disturb(FrameEstimate& frame) {
  if (!frame.pose) return;
  const auto draw = [this] { return Eigen::Vector3d(random_.Normal(), random_.Normal(), random_.Normal()); };
  if (options_.pose_noise > 0) frame.pose->translation += options_.pose_noise * draw();
  if (options_.pose_noise_deg > 0) {
    frame.pose->rotation = frame.pose->rotation * ExpSo3(options_.pose_noise_deg * kRadPerDeg * draw());
  }
}

}  // namespace gaitcam
