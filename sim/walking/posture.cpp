#include "sim/walking/posture.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

MassModel::MassModel(const Robot& robot, const mjModel* nominal) : model_(nominal), data_(MakePoseData(nominal)) {
  for (int j = 0; j < model_->njnt; ++j) {
    if (model_->jnt_type[j] != mjJNT_FREE) continue;
    root_body_ = model_->jnt_bodyid[j];
    mjtNum* qpos = data_->qpos + model_->jnt_qposadr[j];
    mju_zero(qpos, 7);
    qpos[3] = 1;  // the root at the origin: world and root frame are one
  }
  GAITCAM_ASSERT(root_body_ >= 0);
  for (const RobotJoint& joint : robot.joints) {
    const int id = mj_name2id(model_, mjOBJ_JOINT, joint.name.c_str());
    GAITCAM_ASSERT(id >= 0 || joint.kind == RobotJoint::Kind::kFixed);
    joint_id_.push_back(id);
  }
  mass_ = model_->body_subtreemass[root_body_];
  gravity_.resize(size_t(model_->nv));
}

Eigen::Vector3d MassModel::CenterOfMass(const std::vector<double>& joints) {
  GAITCAM_ASSERT(joints.size() == joint_id_.size());
  for (size_t i = 0; i < joints.size(); ++i) {
    if (joint_id_[i] >= 0) data_->qpos[model_->jnt_qposadr[joint_id_[i]]] = joints[i];
  }
  mj_kinematics(model_, data_.get());
  mj_comPos(model_, data_.get());
  return Eigen::Map<const Eigen::Vector3d>(data_->subtree_com + 3 * ptrdiff_t(root_body_));
}

std::vector<double> MassModel::HoldingTorques(const std::array<Contact, 2>& contacts,
                                              const std::array<std::array<int, 6>, 2>& leg_joints) {
  mj_rne(model_, data_.get(), 0, gravity_.data());  // nothing moves: what remains is gravity
  std::vector<double> torques(joint_id_.size(), 0.0);
  for (size_t i = 0; i < torques.size(); ++i) {
    if (joint_id_[i] >= 0) torques[i] = gravity_[size_t(model_->jnt_dofadr[joint_id_[i]])];
  }
  for (int side = 0; side < 2; ++side) {
    for (const int joint : leg_joints[side]) {
      const int id = joint_id_[size_t(joint)];
      const Eigen::Map<const Eigen::Vector3d> axis(data_->xaxis + 3 * ptrdiff_t(id)),
          anchor(data_->xanchor + 3 * ptrdiff_t(id));
      torques[size_t(joint)] -= axis.dot((contacts[side].point - anchor).cross(contacts[side].force));
    }
  }
  return torques;
}

Posture::Posture(const Robot& robot, const mjModel* nominal, double root_height, double lean)
    : legs_{LegKinematics(robot, 0), LegKinematics(robot, 1)},
      mass_(robot, nominal),
      root_height_(root_height),
      lean_(lean),
      joints_(robot.joints.size(), 0.0) {}

Posture::Solution Posture::Solve(const Targets& targets, int iterations) {
  const Eigen::Matrix3d R_PB = RotZ(targets.heading) * RotY(lean_);
  Solution solution;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Eigen::Vector3d com_P = R_PB * com_B_;
    const Eigen::Vector3d root(targets.com.x() - com_P.x(), targets.com.y() - com_P.y(), root_height_);
    solution.X_PB = Pose(R_PB, root);
    for (int side = 0; side < 2; ++side) {
      solution.legs[side] = legs_[side].Inverse(solution.X_PB.Inverse() * targets.X_PA[side]);
      legs_[side].ToJoints(solution.legs[side].angles, joints_);
    }
    com_B_ = mass_.CenterOfMass(joints_);
  }
  com_height_ = (solution.X_PB * com_B_).z();
  return solution;
}

double RootHeight(const LegKinematics& leg, double crouch_m) {
  return leg.ankle_height() + leg.reach() - crouch_m - leg.hip().z();
}

}  // namespace gaitcam
