/// How a camera turns, by integrating the gyroscope that is fixed to it. The gyroscope's bias is learned beside
/// rotations that are known from images.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/units.h"

namespace gaitcam {

/// How wrong a bench leaves a gyroscope, one standard deviation: about its camera's axes, against its clock, in its
/// rate at rest.
struct BenchGyro {
  static constexpr double kMisaligned_rad = 0.5 * kRadPerDeg, kOffset_s = 2e-3, kBias_rad_s = 0.01;
};

class GyroTurn {
 public:
  explicit GyroTurn(const ImuCalibration& imu) : imu_(imu) {}

  /// Samples in time order.
  void Add(const std::vector<ImuSample>& samples);
  void DropBefore(int64_t stamp_ns);
  bool has_samples() const { return !samples_.empty(); }
  const std::vector<ImuSample>& samples() const { return samples_; }  ///< As measured, in the IMU's frame.

  /// The phi of R_FT = Exp(phi), F and T being the camera's frame at the two instants. A sample is the mean rate
  /// over one period about its stamp; time that no sample covers is taken to turn alike.
  /// @returns nothing if samples cover less than 70 % of the interval.
  std::optional<Eigen::Vector3d> Between(int64_t from_ns, int64_t to_ns) const;

  /// A Kalman filter of a constant.
  /// @param excess_rad the rotation vector by which the integrated rotation exceeds the true one, in the camera's
  /// frame.
  /// @param time_s     of the integration, > 0.
  /// @param sigma_rad  standard deviation of each component of `excess_rad`.
  void LearnBias(const Eigen::Vector3d& excess_rad, double time_s, double sigma_rad);
  /// Of the angular rate in the camera's frame, rad/s; taken off by Between().
  const Eigen::Vector3d& bias() const { return bias_; }
  /// Standard deviation of each component, rad/s.
  double bias_sigma() const { return bias_sigma_; }

 private:
  ImuCalibration imu_;
  std::vector<ImuSample> samples_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  double bias_sigma_ = 0.02;
};

}  // namespace gaitcam
