#include "sim/walking/leg_kinematics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// Two legs as of a small humanoid; the right one counts some of its joints the other way round.
Robot TwoLegs() {
  Robot robot;
  robot.name = "legs";
  robot.urdf_file = "legs.urdf";
  robot.links.resize(1);
  for (int side = 0; side < 2; ++side) {
    const double y = side == 0 ? 0.04 : -0.04;
    const Eigen::Vector3d anchors[6] = {{0.01, y, -0.02}, {0, 0, 0},     {0, 0, 0},
                                        {0, 0, -0.065},   {0, 0, -0.06}, {0, 0, 0}};
    const Eigen::Vector3d axes[6] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}};
    for (int i = 0; i < 6; ++i) {
      RobotJoint joint;
      joint.name = std::string(side == 0 ? "l" : "r") + std::to_string(i);
      joint.kind = RobotJoint::Kind::kRevolute;
      joint.parent_link = i == 0 ? 0 : int(robot.links.size()) - 1;
      joint.child_link = int(robot.links.size());
      joint.X_PJ.translation = anchors[i];
      const double sign = side == 1 && (i == 1 || i == 3) ? -1 : 1;
      joint.axis = sign * axes[i];
      joint.lower = sign > 0 ? -1.8 : -2.4;
      joint.upper = sign > 0 ? 2.4 : 1.8;
      robot.legs[side].joints[i] = int(robot.joints.size());
      robot.joints.push_back(joint);
      robot.links.emplace_back();
    }
    robot.legs[side].foot_link = int(robot.links.size()) - 1;
    robot.legs[side].sole_center = {0.008, side == 0 ? 0.003 : -0.003, -0.03};
    robot.legs[side].sole_size = {0.1, 0.06};
  }
  robot.servos.resize(robot.joints.size());
  return robot;
}

LegAngles RandomAngles(RandomStream& random) {
  // Well inside the range where ankle and knee have one solution: knee bent forward, no joint over a right angle.
  return {random.Uniform(-0.8, 0.8), random.Uniform(-0.6, 0.6), random.Uniform(-1.0, 0.5),
          random.Uniform(0.05, 1.8), random.Uniform(-1.0, 0.5), random.Uniform(-0.6, 0.6)};
}

TEST(LegKinematics, InverseUndoesForward) {
  const Robot robot = TwoLegs();
  RandomStream random(1, "leg_kinematics_test");
  for (int side = 0; side < 2; ++side) {
    const LegKinematics leg(robot, side);
    for (int trial = 0; trial < 200; ++trial) {
      const LegAngles expected = RandomAngles(random);
      const LegKinematics::Solution found = leg.Inverse(leg.Forward(expected));
      EXPECT_TRUE(found.reachable);
      // acos loses half the digits near a stretched knee: 1e-16 / sin(0.05).
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(found.angles[i], expected[i], 1e-9) << "joint " << i;
    }
  }
}

TEST(LegKinematics, ForwardFollowsTheRobotsOwnJoints) {
  // The chain of the robot's joint frames, multiplied up, must say the same as the leg's formula.
  const Robot robot = TwoLegs();
  RandomStream random(2, "leg_kinematics_test");
  for (int side = 0; side < 2; ++side) {
    const LegKinematics leg(robot, side);
    const LegAngles angles = RandomAngles(random);
    std::vector<double> joints(robot.joints.size(), 0.0);
    leg.ToJoints(angles, joints);
    EXPECT_EQ(leg.FromJoints(joints), angles);
    Pose X_BF;
    for (const int j : robot.legs[side].joints) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(joints[size_t(j)], robot.joints[size_t(j)].axis));
      X_BF = X_BF * robot.joints[size_t(j)].X_PJ * Pose(turn, Eigen::Vector3d::Zero());
    }
    const Pose X_BA = leg.Forward(angles);
    EXPECT_NEAR((X_BA.translation - X_BF.translation).norm(), 0, 1e-12);
    EXPECT_NEAR(RotationAngle(X_BA.rotation, X_BF.rotation), 0, 1e-7);  // acos of nearly 1
  }
}

TEST(LegKinematics, ReadsItsMeasuresFromTheRobot) {
  const LegKinematics leg(TwoLegs(), 0);
  EXPECT_NEAR((leg.hip() - Eigen::Vector3d(0.01, 0.04, -0.02)).norm(), 0, 1e-12);
  EXPECT_NEAR(leg.reach(), 0.125, 1e-12);
  EXPECT_NEAR(leg.ankle_height(), 0.03, 1e-12);
}

TEST(LegKinematics, SaysWhenAnAnkleIsOutOfReach) {
  const LegKinematics leg(TwoLegs(), 0);
  const LegKinematics::Solution far =
      leg.Inverse({Eigen::Matrix3d::Identity(), leg.hip() - Eigen::Vector3d(0, 0, 0.13)});
  EXPECT_FALSE(far.reachable);
  EXPECT_NEAR(far.distance, 0.13, 1e-12);
  EXPECT_NEAR(far.angles[3], 0, 0.05);  // stretched towards it
}

TEST(LegKinematics, SaysWhichJointIsBeyondItsLimit) {
  Robot robot = TwoLegs();
  robot.joints[size_t(robot.legs[0].joints[3])].upper = 0.5;
  const LegKinematics leg(robot, 0);
  const LegKinematics::Solution bent =
      leg.Inverse({Eigen::Matrix3d::Identity(), leg.hip() - Eigen::Vector3d(0, 0, 0.09)});
  EXPECT_FALSE(bent.reachable);
  EXPECT_EQ(bent.beyond_limit, 3);
}

TEST(LegKinematics, RefusesALegWithoutAClosedForm) {
  Robot robot = TwoLegs();
  robot.joints[size_t(robot.legs[0].joints[3])].X_PJ.translation.x() = 0.01;
  try {
    LegKinematics leg(robot, 0);
    FAIL() << "a knee before the hip was accepted";
  } catch (const BadInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("legs.urdf: joint l3: the knee must lie straight below the hip"));
  }
  robot = TwoLegs();
  robot.joints[size_t(robot.legs[1].joints[0])].axis = Eigen::Vector3d(0, 1, 0);
  EXPECT_THROW(LegKinematics(robot, 1), BadInput);
}

}  // namespace
}  // namespace gaitcam
