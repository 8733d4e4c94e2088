#include "sim/walking/state_estimator.h"

#include <cmath>

#include "algorithms/core/se3.h"
#include "sim/walking/preview_control.h"

namespace gaitcam {
namespace {

double Yaw(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); }

}  // namespace

StateEstimator::StateEstimator(const Robot& robot, const EstimatorOptions& options, const Pose& X_OB)
    : options_(options), legs_{LegKinematics(robot, 0), LegKinematics(robot, 1)}, X_OB_(X_OB) {
  // The IMU may sit on a link behind fixed joints, or on the trunk itself.
  Pose X_BL;
  for (int link = robot.imu.link; link > 0; link = robot.joints[size_t(link - 1)].parent_link) {
    X_BL = robot.joints[size_t(link - 1)].X_PJ * X_BL;
  }
  X_BI_ = X_BL * robot.imu.X_LS;
}

void StateEstimator::Update(const ImuSample& imu, const std::vector<double>& joints, double period_s, int stance,
                            bool calibrate, MassModel& mass_model) {
  UpdateBase(imu, joints, period_s, stance, calibrate);
  UpdateCom(joints, period_s, mass_model);
}

void StateEstimator::UpdateBase(const ImuSample& imu, const std::vector<double>& joints, double period_s, int stance,
                                bool calibrate) {
  UpdateAttitude(imu, period_s, calibrate);
  for (size_t side = 0; side < 2; ++side) X_BA_[side] = legs_[side].Forward(legs_[side].FromJoints(joints));
  UpdateOdometry(stance);
}

void StateEstimator::UpdateAttitude(const ImuSample& imu, double period_s, bool calibrate) {
  if (calibrate) {
    rate_sum_ += imu.angular_rate;
    bias_ = rate_sum_ / ++rate_count_;
  }
  angular_rate_ = X_BI_.rotation * (imu.angular_rate - bias_);
  // Mahony's direct form: the vertical by the accelerometer, crossed with where the filter believes it, is the error.
  const Eigen::Vector3d up_measured = (X_BI_.rotation * imu.specific_force).normalized();
  const Eigen::Vector3d up_believed = X_OB_.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d error = up_measured.cross(up_believed);
  const bool sane = imu.specific_force.norm() > 0.3 * kGravity && imu.specific_force.norm() < 3 * kGravity;
  const Eigen::Vector3d correction = sane ? Eigen::Vector3d(options_.attitude_gain * error) : Eigen::Vector3d::Zero();
  X_OB_.rotation = (X_OB_.rotation * ExpSo3((angular_rate_ + correction) * period_s)).normalized();
  const Eigen::Vector3d up = X_OB_.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  roll_ = std::atan2(up.y(), up.z());
  pitch_ = std::atan2(-up.x(), std::hypot(up.y(), up.z()));
}

void StateEstimator::UpdateCom(const std::vector<double>& joints, double period_s, MassModel& mass_model) {
  const Eigen::Vector3d com_B = mass_model.CenterOfMass(joints);
  const Eigen::Matrix3d level = RotY(pitch_) * RotX(roll_);
  for (int side = 0; side < 2; ++side) {
    const double foot_heading = Yaw(level * X_BA_[side].R());
    const Eigen::Vector3d from_ankle = RotZ(-foot_heading) * level * (com_B - X_BA_[side].translation);
    const Eigen::Vector2d position = from_ankle.head<2>();
    if (has_com_) {
      const Eigen::Vector2d velocity = (position - com_[side].position) / period_s;
      const double weight = period_s / (period_s + options_.velocity_filter_s);
      com_[side].velocity += weight * (velocity - com_[side].velocity);
    }
    com_[side].position = position;
  }
  has_com_ = true;
}

void StateEstimator::UpdateOdometry(int stance) {
  const auto sole_in_O = [&](int side) { return X_OB_.rotation * (X_BA_[side] * legs_[side].sole()); };
  if (anchor_ < 0 || (stance >= 0 && stance != anchor_)) {
    // The first foot stands where the robot was put; each next one where it stands by the one before.
    const int next = stance >= 0 ? stance : 0;
    anchor_O_ = X_OB_.translation + sole_in_O(next);
    anchor_O_.z() = 0;
    anchor_ = next;
  }
  X_OB_.translation = anchor_O_ - sole_in_O(anchor_);
}

}  // namespace gaitcam
