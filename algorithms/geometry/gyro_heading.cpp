#include "algorithms/geometry/gyro_heading.h"

#include <cmath>
#include <numbers>

namespace gaitcam {

GyroHeading::GyroHeading(const ImuCalibration& imu, const Eigen::Vector3d& up_C) : imu_(imu), up_(imu, up_C) {}

void GyroHeading::Add(const std::vector<ImuSample>& samples) { up_.Add(samples, imu_.X_CI.rotation * bias_.bias()); }

void GyroHeading::Stand(const std::vector<ImuSample>& samples) {
  bias_.Stand(samples);
  standing_samples_ += samples.size();
}

void GyroHeading::LearnBias() {
  const Eigen::Vector3d before = bias_.bias();
  bias_.Learn();
  const Eigen::Vector3d change_C = imu_.X_CI.rotation * (bias_.bias() - before);
  if (has_gyroscope()) offset_rad_ -= change_C.dot(up_.up_C()) * double(standing_samples_) / imu_.rate_hz;
  standing_samples_ = 0;
  stale_ = !bias_.learned();
}

void GyroHeading::Observe(double heading_rad, double at_heading_rad) {
  constexpr double kGain = 0.2;
  const double error = std::remainder(heading_rad - at_heading_rad, 2 * std::numbers::pi);
  offset_rad_ += (stale_ ? 1 : kGain) * error;
  stale_ = false;
}

}  // namespace gaitcam
