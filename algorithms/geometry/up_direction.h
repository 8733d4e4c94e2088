/// The vertical in the frame of a camera that sways as its robot walks: a complementary filter of gyroscope and
/// accelerometer, slow enough for the accelerations of steps to cancel out.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"

namespace gaitcam {

class UpDirection {
 public:
  /// @param up_C before the first sample, a unit vector in the camera's frame. @param time_s time constant of the
  /// accelerometer's part; some steps.
  UpDirection(const ImuCalibration& imu, const Eigen::Vector3d& up_C, double time_s = 2.0);

  /// Samples in time order. Without an IMU nothing changes. Where samples are missing the camera is taken to turn by
  /// the mean of the rates before and after, for at most 0.25 s.
  /// @param gyro_bias_C of the angular rate, rad/s in the camera's frame, as far as known.
  void Add(const std::vector<ImuSample>& samples, const Eigen::Vector3d& gyro_bias_C = Eigen::Vector3d::Zero());
  const Eigen::Vector3d& up_C() const { return up_C_; }
  /// Rotation about the vertical since the first sample, rad, left positive; drifts with the gyroscope's residual bias.
  double heading_rad() const { return heading_rad_; }

 private:
  struct Last {
    int64_t stamp_ns;
    Eigen::Vector3d rate_C;
  };

  double SilentTime(int64_t stamp_ns) const;
  void Turn(const Eigen::Vector3d& turn);

  ImuCalibration imu_;
  Eigen::Vector3d up_C_;
  double time_s_, heading_rad_ = 0;
  std::optional<Last> last_;
};

}  // namespace gaitcam
