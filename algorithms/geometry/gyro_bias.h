/// The bias of a gyroscope: its mean reading at rest.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/observation.h"

namespace gaitcam {

class GyroBias {
 public:
  /// Samples taken while the robot stands. Rates larger than any bias are left out: the head may turn.
  void Stand(const std::vector<ImuSample>& samples);
  /// Takes the mean of the samples since the last call for the bias, if there were enough of them.
  void Learn();
  /// Of the angular rate, rad/s, in the IMU's frame; 0 until learned.
  const Eigen::Vector3d& bias() const { return bias_; }
  bool learned() const { return learned_; }

 private:
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero(), sum_ = Eigen::Vector3d::Zero();
  int counted_ = 0, seen_ = 0;
  bool learned_ = false;
};

}  // namespace gaitcam
