/// A six-joint leg: from joint angles to the ankle and back, in closed form.
///
/// The three hip axes (yaw, roll, pitch) meet in one point, the two ankle axes (pitch, roll) in another, and the knee
/// lies straight between them when the leg is stretched; then the inverse has a closed form (Kajita, "Introduction to
/// Humanoid Robotics", section 2.5). Frames: B the root link; A the ankle, at the ankle's point, with B's axes when all
/// joints are 0. Angles are counted in the leg's own sense: yaw about z, roll about x, pitch about y (a bent knee is
/// positive), and `joint_sign` says how the robot's joints count.

#pragma once

#include <array>
#include <optional>

#include "algorithms/core/pose.h"
#include "models/code/robots/robot.h"

namespace gaitcam {

using LegAngles = std::array<double, 6>;  ///< rad: hip yaw, roll, pitch, knee, ankle pitch, ankle roll.

class LegKinematics {
 public:
  /// @param side 0 left, 1 right.
  /// @throws BadInput naming the robot's file and the joint whose position or axis does not allow the closed form.
  LegKinematics(const Robot& robot, int side);

  struct Solution {
    LegAngles angles;
    double distance = 0;     ///< Hip to ankle as asked for, m; more than reach() was cut to it.
    int beyond_limit = -1;   ///< Which of the six joints is the first outside its limits, or -1.
    bool reachable = false;  ///< Neither too far nor beyond a limit.
  };
  /// Angles that bring the ankle to X_BA; of an ankle too far away, the nearest that the leg can do.
  Solution Inverse(const Pose& X_BA) const;
  /// X_BA for given angles.
  Pose Forward(const LegAngles& angles) const;

  LegAngles FromJoints(const std::vector<double>& joints) const;  ///< Order of Robot::joints.
  void ToJoints(const LegAngles& angles, std::vector<double>& joints) const;

  const std::array<int, 6>& joints() const { return joints_; }  ///< Indices into Robot::joints.
  const Eigen::Vector3d& hip() const { return hip_; }           ///< In B, m.
  double reach() const { return thigh_ + shank_; }              ///< Hip to ankle, stretched, m.
  double ankle_height() const { return -sole_.z(); }            ///< Over the sole, m.
  /// The middle of the sole in A, m.
  const Eigen::Vector3d& sole() const { return sole_; }
  const Eigen::Vector2d& sole_size() const { return sole_size_; }

 private:
  std::array<int, 6> joints_;
  std::array<double, 6> joint_sign_, lower_, upper_;
  Eigen::Vector3d hip_, sole_;
  Eigen::Vector2d sole_size_;
  double thigh_ = 0, shank_ = 0;
};

}  // namespace gaitcam
