/// The vertical in the frame of a camera that sways as its robot walks: a complementary filter of gyroscope and
/// accelerometer, slow enough for the accelerations of steps to cancel out.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"

namespace gaitcam {

class UpDirection {
 public:
  /// @param up_C before the first sample, a unit vector in the camera's frame. @param time_s time constant of the
  /// accelerometer's part; some steps.
  UpDirection(const ImuCalibration& imu, const Eigen::Vector3d& up_C, double time_s = 2.0);

  /// Samples in time order. Without an IMU nothing changes.
  /// @param gyro_bias_C of the angular rate, rad/s in the camera's frame, as far as known.
  void Add(const std::vector<ImuSample>& samples, const Eigen::Vector3d& gyro_bias_C = Eigen::Vector3d::Zero());
  const Eigen::Vector3d& up_C() const { return up_C_; }
  /// Rotation about the vertical since the first sample, rad, left positive; drifts with the gyroscope's residual bias.
  double heading_rad() const { return heading_rad_; }

 private:
  ImuCalibration imu_;
  Eigen::Vector3d up_C_;
  double time_s_, heading_rad_ = 0;
};

}  // namespace gaitcam
