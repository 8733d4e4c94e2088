/// What a gyroscope reads while it rests is its bias.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/observation.h"

namespace gaitcam {

class GyroBias {
 public:
  /// Samples taken while the robot stands. Those that turn as no bias does are not counted: it may look around.
  void Stand(const std::vector<ImuSample>& samples);
  /// It walks on: from now on the bias is the mean of what was counted since the last call, if that was enough.
  void Learn();
  /// Of the angular rate, rad/s, in the IMU's own frame; 0 until something was learned.
  const Eigen::Vector3d& bias() const { return bias_; }
  bool learned() const { return learned_; }

 private:
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero(), sum_ = Eigen::Vector3d::Zero();
  int counted_ = 0, seen_ = 0;
  bool learned_ = false;
};

}  // namespace gaitcam
