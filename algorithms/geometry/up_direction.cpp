#include "algorithms/geometry/up_direction.h"

#include "algorithms/core/se3.h"

namespace gaitcam {

UpDirection::UpDirection(const ImuCalibration& imu, const Eigen::Vector3d& up_C, double time_s)
    : imu_(imu), up_C_(up_C.normalized()), time_s_(time_s) {}

void UpDirection::Add(const std::vector<ImuSample>& samples, const Eigen::Vector3d& gyro_bias_C) {
  if (imu_.rate_hz <= 0) return;
  const double dt = 1 / imu_.rate_hz;
  for (const ImuSample& sample : samples) {
    const Eigen::Vector3d turn = dt * (imu_.X_CI.rotation * sample.angular_rate - gyro_bias_C);
    heading_rad_ += turn.dot(up_C_);
    // A fixed direction rotates the other way in the camera's frame.
    up_C_ = ExpSo3(-turn) * up_C_;
    const Eigen::Vector3d support = imu_.X_CI.rotation * sample.specific_force;
    if (support.norm() > 0) up_C_ += dt / time_s_ * (support.normalized() - up_C_);
    up_C_.normalize();
  }
}

}  // namespace gaitcam
