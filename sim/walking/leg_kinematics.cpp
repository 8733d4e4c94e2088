#include "sim/walking/leg_kinematics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kAnchorTolerance = 1e-4;  // m: allows for rounding in the URDF
constexpr double kAxisTolerance = 1e-3;    // rad

const char* const kJointRoles[6] = {"hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"};

[[noreturn]] void Fail(const Robot& robot, int joint, const std::string& what) {
  throw BadInput(robot.urdf_file.string() + ": joint " + robot.joints[size_t(joint)].name + ": " + what);
}

/// Pose of a joint's frame in the root link with all joints at zero.
Pose ZeroPose(const Robot& robot, int joint) {
  const RobotJoint& j = robot.joints[size_t(joint)];
  // joints[i] is the parent joint of link i + 1.
  return j.parent_link == 0 ? j.X_PJ : ZeroPose(robot, j.parent_link - 1) * j.X_PJ;
}

/// +1 or -1 if the axis runs along `expected` or against it. @throws BadInput otherwise.
double AxisSign(const Robot& robot, int joint, const Pose& zero, int role) {
  const Eigen::Vector3d expected = role == 0                ? Eigen::Vector3d::UnitZ()
                                   : role == 1 || role == 5 ? Eigen::Vector3d::UnitX()
                                                            : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d axis = zero.rotation * robot.joints[size_t(joint)].axis;
  if (axis.cross(expected).norm() > kAxisTolerance) {
    Fail(robot, joint,
         std::string("as ") + kJointRoles[role] + " its axis must run along the root's " +
             (role == 0                ? "z"
              : role == 1 || role == 5 ? "x"
                                       : "y") +
             " axis when all joints are 0");
  }
  return axis.dot(expected) > 0 ? 1 : -1;
}

}  // namespace

LegKinematics::LegKinematics(const Robot& robot, int side) {
  const RobotLeg& leg = robot.legs[size_t(side)];
  joints_ = leg.joints;
  std::array<Eigen::Vector3d, 6> anchor;
  for (int i = 0; i < 6; ++i) {
    const RobotJoint& joint = robot.joints[size_t(joints_[i])];
    const Pose zero = ZeroPose(robot, joints_[i]);
    anchor[i] = zero.translation;
    joint_sign_[i] = AxisSign(robot, joints_[i], zero, i);
    const bool endless = joint.kind == RobotJoint::Kind::kContinuous;
    const double lower = endless ? -std::numeric_limits<double>::infinity() : joint.lower;
    const double upper = endless ? std::numeric_limits<double>::infinity() : joint.upper;
    lower_[i] = joint_sign_[i] > 0 ? lower : -upper;
    upper_[i] = joint_sign_[i] > 0 ? upper : -lower;
  }
  // Each axis is a line: only the coordinates across it matter.
  hip_ = {anchor[0].x(), anchor[0].y(), anchor[1].z()};
  const Eigen::Vector3d ankle(anchor[4].x(), anchor[5].y(), anchor[4].z());
  const auto same = [&](int role, int axis, double expected, const char* what) {
    if (std::abs(anchor[role][axis] - expected) > kAnchorTolerance) Fail(robot, joints_[role], what);
  };
  same(1, 1, hip_.y(), "the hip's roll axis must meet its yaw axis");
  same(2, 0, hip_.x(), "the hip's pitch axis must meet its yaw axis");
  same(2, 2, hip_.z(), "the hip's pitch axis must meet its roll axis");
  same(3, 0, hip_.x(), "the knee must lie straight below the hip when all joints are 0");
  same(4, 0, hip_.x(), "the ankle must lie straight below the hip when all joints are 0");
  same(5, 1, hip_.y(), "the ankle's roll axis must lie straight below the hip when all joints are 0");
  same(5, 2, ankle.z(), "the ankle's roll axis must meet its pitch axis");
  thigh_ = hip_.z() - anchor[3].z();
  shank_ = anchor[3].z() - ankle.z();
  if (thigh_ <= 0 || shank_ <= 0) Fail(robot, joints_[3], "the knee must lie between hip and ankle");
  // The last joint's frame need not have the ankle's axes: the sole's position is computed in the root frame.
  const Pose X_BF = ZeroPose(robot, leg.foot_link - 1);
  sole_ = X_BF * leg.sole_center - ankle;
  sole_size_ = leg.sole_size;
}

LegKinematics::Solution LegKinematics::Inverse(const Pose& X_BA) const {
  Solution solution;
  const Eigen::Matrix3d R_BA = X_BA.R();
  const Eigen::Vector3d r = R_BA.transpose() * (hip_ - X_BA.translation);  // hip seen from the ankle
  solution.distance = r.norm();
  // A stretched knee is a singularity; the reach is limited to just below it.
  const double distance = std::clamp(solution.distance, 1e-6, reach() - 1e-5);

  LegAngles& q = solution.angles;
  const double cos_knee = (distance * distance - thigh_ * thigh_ - shank_ * shank_) / (2 * thigh_ * shank_);
  q[3] = std::acos(std::clamp(cos_knee, -1.0, 1.0));
  const double ankle_angle = std::atan2(thigh_ * std::sin(q[3]), shank_ + thigh_ * std::cos(q[3]));
  q[5] = std::atan2(r.y(), r.z());
  q[4] = -std::atan2(r.x(), std::hypot(r.y(), r.z())) - ankle_angle;

  const Eigen::Matrix3d R = R_BA * RotX(-q[5]) * RotY(-q[4] - q[3]);  // = Rz(q0) Rx(q1) Ry(q2)
  q[0] = std::atan2(-R(0, 1), R(1, 1));
  q[1] = std::atan2(R(2, 1), std::hypot(R(0, 1), R(1, 1)));
  q[2] = std::atan2(-R(2, 0), R(2, 2));

  for (int i = 5; i >= 0; --i) {
    if (q[i] < lower_[i] || q[i] > upper_[i]) solution.beyond_limit = i;
  }
  solution.reachable = solution.beyond_limit < 0 && solution.distance <= reach() - 1e-5;
  return solution;
}

Pose LegKinematics::Forward(const LegAngles& q) const {
  const Eigen::Matrix3d thigh = RotZ(q[0]) * RotX(q[1]) * RotY(q[2]);
  const Eigen::Matrix3d shank = thigh * RotY(q[3]);
  return {shank * RotY(q[4]) * RotX(q[5]), hip_ - thigh_ * thigh.col(2) - shank_ * shank.col(2)};
}

LegAngles LegKinematics::FromJoints(const std::vector<double>& joints) const {
  LegAngles angles;
  for (int i = 0; i < 6; ++i) angles[i] = joint_sign_[i] * joints[size_t(joints_[i])];
  return angles;
}

void LegKinematics::ToJoints(const LegAngles& angles, std::vector<double>& joints) const {
  for (int i = 0; i < 6; ++i) joints[size_t(joints_[i])] = joint_sign_[i] * angles[i];
}

}  // namespace gaitcam
