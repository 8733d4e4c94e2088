#include "sim/walking/servo_feedforward.h"

#include <algorithm>

namespace gaitcam {

ServoFeedforward::ServoFeedforward(const Robot& robot, double stiffness, double period_s, double share)
    : period_s_(period_s), share_(share), offsets_(robot.joints.size(), 0.0) {
  for (const RobotLeg& leg : robot.legs) {
    for (const int joint : leg.joints) {
      const ServoOptions& servo = robot.servos[size_t(joint)];
      const double kp = stiffness * servo.kp;
      if (kp <= 0) continue;
      servos_.push_back({joint, kp, (stiffness * servo.kv + servo.damping) / kp, servo.torque_limit});
    }
  }
}

const std::vector<double>& ServoFeedforward::Update(const std::vector<double>& angles,
                                                    const std::vector<double>& torques) {
  if (last_angles_.empty()) last_angles_ = angles;
  for (const Servo& servo : servos_) {
    const size_t j = size_t(servo.joint);
    const double rate = (angles[j] - last_angles_[j]) / period_s_;
    const double torque = std::clamp(torques[j], -servo.torque_limit, servo.torque_limit);
    offsets_[j] = share_ * (torque / servo.kp + servo.lag_s * rate);
  }
  last_angles_ = angles;
  return offsets_;
}

}  // namespace gaitcam
