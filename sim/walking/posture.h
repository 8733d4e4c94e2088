/// Whole-body posture: leg angles for given poses of the feet and a given horizontal position of the centre of mass.
///
/// The legs weigh as much as the trunk, so the root link is not the centre of mass. Given both feet, the root's
/// position is corrected until the mass of all links, as the nominal MuJoCo model has them, lies where the cart-table
/// plan puts it.

#pragma once

#include <array>
#include <vector>

#include "sim/walking/leg_kinematics.h"
#include "sim/world/world.h"

namespace gaitcam {

/// The centre of mass of a robot's nominal model.
class MassModel {
 public:
  /// @param nominal not owned, must outlive this; its joints bear the names of the robot's joints.
  MassModel(const Robot& robot, const mjModel* nominal);

  /// In the root link's frame, m. @param joints in the order of Robot::joints.
  Eigen::Vector3d CenterOfMass(const std::vector<double>& joints);

  /// A force that the floor exerts on a leg, in the root link's frame.
  struct Contact {
    Eigen::Vector3d point;  ///< m
    Eigen::Vector3d force;  ///< N
  };
  /// Torques that hold the joints of the last CenterOfMass() still, the root upright: gravity on the links that a joint
  /// carries, less what the floor takes. N m, in the order of Robot::joints; 0 for fixed joints.
  /// @param leg_joints for each contact, the joints between root and foot.
  std::vector<double> HoldingTorques(const std::array<Contact, 2>& contacts,
                                     const std::array<std::array<int, 6>, 2>& leg_joints);

  double mass() const { return mass_; }  ///< kg

 private:
  const mjModel* model_;
  MjDataPtr data_;
  int root_body_ = -1;
  double mass_ = 0;
  std::vector<int> joint_id_;  ///< In the model, per joint of the robot; -1 for fixed ones.
  std::vector<double> gravity_;
};

class Posture {
 public:
  /// @param root_height of the root link over the floor, m. @param lean pitch of the root, rad forward.
  Posture(const Robot& robot, const mjModel* nominal, double root_height, double lean);

  struct Targets {
    Eigen::Vector2d com;       ///< Horizontal, m in the plan's frame P.
    double heading = 0;        ///< Of the root, rad.
    std::array<Pose, 2> X_PA;  ///< Ankles, left and right.
  };
  struct Solution {
    Pose X_PB;  ///< Root link.
    std::array<LegKinematics::Solution, 2> legs;
  };
  /// Starts from the correction of the last call: from one control tick to the next, 2 iterations are exact to 0.1 mm.
  Solution Solve(const Targets& targets, int iterations);

  /// Joint positions with which the links other than the legs count (arms, neck); legs are overwritten.
  std::vector<double>& joints() { return joints_; }
  MassModel& mass_model() { return mass_; }
  const LegKinematics& leg(int side) const { return legs_[size_t(side)]; }
  /// Height of the centre of mass over the floor in the last solution, m.
  double com_height() const { return com_height_; }

 private:
  std::array<LegKinematics, 2> legs_;
  MassModel mass_;
  double root_height_, lean_;
  std::vector<double> joints_;
  Eigen::Vector3d com_B_ = Eigen::Vector3d::Zero();
  double com_height_ = 0;
};

/// Height of the root link over the floor when the hips are `crouch_m` lower than over stretched legs, m.
double RootHeight(const LegKinematics& leg, double crouch_m);

}  // namespace gaitcam
