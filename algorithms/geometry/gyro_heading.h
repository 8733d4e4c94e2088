/// The heading of a robot by its gyroscope, with the bias learned whenever it stands.

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/gyro_bias.h"
#include "algorithms/geometry/up_direction.h"

namespace gaitcam {

class GyroHeading {
 public:
  /// @param up_C the vertical before the first sample, a unit vector in the camera's frame.
  GyroHeading(const ImuCalibration& imu, const Eigen::Vector3d& up_C);

  /// All samples in time order. Without an IMU the heading stays what it is corrected to.
  void Add(const std::vector<ImuSample>& samples);
  /// Those of them that were taken while the robot stood.
  void Stand(const std::vector<ImuSample>& samples);
  /// The robot walks on: what it has read while it stood becomes the bias, and what the heading has drifted by
  /// meanwhile is taken back.
  void LearnBias();
  /// Adds to the heading.
  void Turn(double angle_rad) { offset_rad_ += angle_rad; }
  /// Draws the heading towards one that was observed, by a fifth of the difference, or onto it if the heading is stale.
  void Observe(double heading_rad, double at_heading_rad);

  bool has_gyroscope() const { return imu_.rate_hz > 0; }
  bool bias_is_known() const { return bias_.learned(); }
  /// Against the camera's azimuth at the first sample, left positive, not wrapped, rad.
  double heading_rad() const { return up_.heading_rad() + offset_rad_; }
  /// Nothing has observed it since the start or, without a known bias, since the robot stood last.
  bool stale() const { return stale_; }
  /// The vertical in the camera's frame, a unit vector.
  const Eigen::Vector3d& up_C() const { return up_.up_C(); }

 private:
  ImuCalibration imu_;
  UpDirection up_;
  GyroBias bias_;
  double offset_rad_ = 0;
  size_t standing_samples_ = 0;  ///< Since the bias was learned last.
  bool stale_ = true;
};

}  // namespace gaitcam
