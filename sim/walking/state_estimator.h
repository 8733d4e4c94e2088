/// State estimation of the walking controller: attitude, centre of mass over the feet and leg odometry, from a noisy
/// IMU, joint encoders and the nominal mass model. It uses no truth.
///
/// Frames: B root link; I the IMU; O the odometry's world, which starts as the pose at which the robot was put, its z
/// axis up. Attitude is Mahony's complementary filter on SO(3) (Mahony, Hamel, Pflimlin, "Nonlinear Complementary
/// Filters on the Special Orthogonal Group", IEEE TAC 2008): the gyroscope is integrated, the accelerometer pulls it
/// slowly to the vertical.

#pragma once

#include <array>
#include <optional>

#include "algorithms/core/observation.h"
#include "models/code/robots/robot.h"
#include "sim/walking/leg_kinematics.h"
#include "sim/walking/path.h"
#include "sim/walking/posture.h"

namespace gaitcam {

struct EstimatorOptions {
  double attitude_gain = 0.5;       ///< Gain of the accelerometer's correction of roll and pitch, 1/s.
  double velocity_filter_s = 0.02;  ///< Low-pass of the centre of mass's velocity from encoders.
};

/// The centre of mass seen from one foot.
struct ComOverFoot {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< From the ankle, m; x along the foot, y left, both level.
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< Over the floor while this foot stands, m/s, same axes.
};

class StateEstimator {
 public:
  /// @param X_OB where the root link is at first, upright.
  StateEstimator(const Robot& robot, const EstimatorOptions& options, const Pose& X_OB);

  /// @param stance the foot that carries the robot (0, 1), or -1 on both feet. At rest: `calibrate` lets the
  /// gyroscope's bias be learnt.
  void Update(const ImuSample& imu, const std::vector<double>& joints, double period_s, int stance, bool calibrate,
              MassModel& mass_model);

  /// The same without the centre of mass over the feet.
  void UpdateBase(const ImuSample& imu, const std::vector<double>& joints, double period_s, int stance, bool calibrate);

  double roll() const { return roll_; }                                  ///< rad, about the root's x axis.
  double pitch() const { return pitch_; }                                ///< rad, positive leans forward.
  const Eigen::Vector3d& angular_rate() const { return angular_rate_; }  ///< Of B, in B, bias removed, rad/s.
  const ComOverFoot& com_over_foot(int side) const { return com_[size_t(side)]; }
  /// Leg odometry: the stance foot is assumed not to slip; the heading is the gyroscope's.
  const Pose& X_OB() const { return X_OB_; }

 private:
  void UpdateAttitude(const ImuSample& imu, double period_s, bool calibrate);
  void UpdateCom(const std::vector<double>& joints, double period_s, MassModel& mass_model);
  void UpdateOdometry(int stance);

  EstimatorOptions options_;
  std::array<LegKinematics, 2> legs_;
  Pose X_BI_;
  Pose X_OB_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero(), rate_sum_ = Eigen::Vector3d::Zero();
  int rate_count_ = 0;
  Eigen::Vector3d angular_rate_ = Eigen::Vector3d::Zero();
  double roll_ = 0, pitch_ = 0;
  std::array<Pose, 2> X_BA_;  ///< Ankles by the encoders.
  std::array<ComOverFoot, 2> com_;
  bool has_com_ = false;
  int anchor_ = -1;                                     ///< The foot whose contact the odometry integrates from.
  Eigen::Vector3d anchor_O_ = Eigen::Vector3d::Zero();  ///< Middle of its sole.
};

}  // namespace gaitcam
