#include "algorithms/geometry/up_direction.h"

#include <algorithm>

#include "algorithms/core/se3.h"

namespace gaitcam {

UpDirection::UpDirection(const ImuCalibration& imu, const Eigen::Vector3d& up_C, double time_s)
    : imu_(imu), up_C_(up_C.normalized()), time_s_(time_s) {}

void UpDirection::Add(const std::vector<ImuSample>& samples, const Eigen::Vector3d& gyro_bias_C) {
  if (imu_.rate_hz <= 0) return;
  const double dt = 1 / imu_.rate_hz;
  for (const ImuSample& sample : samples) {
    const Eigen::Vector3d rate_C = imu_.X_CI.rotation * sample.angular_rate - gyro_bias_C;
    if (last_) Turn(SilentTime(sample.stamp_ns) * 0.5 * (last_->rate_C + rate_C));
    Turn(dt * rate_C);
    const Eigen::Vector3d support = imu_.X_CI.rotation * sample.specific_force;
    if (support.norm() > 0) up_C_ += dt / time_s_ * (support.normalized() - up_C_);
    up_C_.normalize();
    last_ = Last{sample.stamp_ns, rate_C};
  }
}

/// How long nothing was measured before a sample, which itself stands for one period.
double UpDirection::SilentTime(int64_t stamp_ns) const {
  constexpr double kLongest_s = 0.25;  // within a sway; rates farther apart do not tell what lies between
  const double period_s = 1 / imu_.rate_hz, silent_s = double(stamp_ns - last_->stamp_ns) * 1e-9 - period_s;
  return silent_s > 0.5 * period_s ? std::min(silent_s, kLongest_s) : 0;
}

void UpDirection::Turn(const Eigen::Vector3d& turn) {
  heading_rad_ += turn.dot(up_C_);
  // A fixed direction rotates the other way in the camera's frame.
  up_C_ = ExpSo3(-turn) * up_C_;
}

}  // namespace gaitcam
