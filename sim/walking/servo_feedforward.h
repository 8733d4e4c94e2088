/// Feed-forward of position servos: targets at which the joints follow the plan.
///
/// A position servo's torque is proportional to its error: kp (target - q) - kv q'. Under load it has a steady-state
/// error, and in motion it lags by (kv + damping) / kp seconds. Known loads and speeds are therefore added to the
/// target:
///   target = q + (torque + (kv + damping) q') / kp

#pragma once

#include <vector>

#include "models/code/robots/robot.h"

namespace gaitcam {

class ServoFeedforward {
 public:
  /// @param stiffness factor on the leg servos' kp and kv. @param share of the correction that is applied, 0 to 1.
  ServoFeedforward(const Robot& robot, double stiffness, double period_s, double share);

  /// Offsets to the targets of the legs' joints, in the order of Robot::joints (0 for others).
  /// @param angles planned, one period after the last call's. @param torques expected, N m.
  const std::vector<double>& Update(const std::vector<double>& angles, const std::vector<double>& torques);

 private:
  struct Servo {
    int joint;
    double kp, lag_s, torque_limit;
  };
  std::vector<Servo> servos_;
  double period_s_, share_;
  std::vector<double> last_angles_, offsets_;
};

}  // namespace gaitcam
