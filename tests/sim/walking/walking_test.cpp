// Whole walks through physics, short ones; `gaitcam experiment walking` walks the long ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

ShippedWalkOptions Trial(const std::string& robot, const std::string& preset) {
  ShippedWalkOptions options;
  options.robot = robot;
  options.preset = preset;
  options.path.length_m = 2;
  options.physics.mass_noise_ratio = 0.1;
  options.physics.friction_noise_ratio = 0.1;
  return options;
}

class EveryHumanoid : public testing::TestWithParam<const char*> {};

TEST_P(EveryHumanoid, WalksStraightToItsGoalAndStands) {
  const WalkTrialResult walk = RunWalkTrial(Trial(GetParam(), "normal"));
  EXPECT_TRUE(walk.finished);
  // Root over the path's end: steps end within 2 mm of it as planned; what slips since the last step was planned, and
  // the sway, are some centimetres.
  EXPECT_NEAR(walk.end.position.x(), 2, 0.06);
  EXPECT_LT(Worst(walk.path_error_m), 0.06);  // twice what the walking matrix shows over 20 m
  EXPECT_LT(walk.max_tilt_rad, 0.12);         // likewise, robovie_m's 3.5 degrees
}

INSTANTIATE_TEST_SUITE_P(Walking, EveryHumanoid, testing::Values("khr1hv", "robovie_m", "nimbro"));

TEST(Walking, BriskAroundACircleKeepsToIt) {
  ShippedWalkOptions options = Trial("khr1hv", "brisk");
  options.path.kind = PathKind::kCircle;
  options.path.diameter_m = 1;
  const WalkTrialResult walk = RunWalkTrial(options);
  EXPECT_TRUE(walk.finished);
  EXPECT_NEAR(walk.end.position.norm(), 0, 0.12);
  EXPECT_LT(Worst(walk.path_error_m), 0.12);  // a circle four times tighter than the matrix's, where it is 4 cm
  EXPECT_GT(walk.speed_m_s, 0.15);
}

TEST(Walking, TurnsOnTheSpotAndComesBack) {
  ShippedWalkOptions options = Trial("khr1hv", "normal");
  options.path.kind = PathKind::kThereAndBack;
  options.path.length_m = 0.5;
  const WalkTrialResult walk = RunWalkTrial(options);
  EXPECT_TRUE(walk.finished);
  EXPECT_NEAR(walk.end.position.norm(), 0, 0.1);
  EXPECT_NEAR(std::abs(walk.end.heading), 3.14159, 0.2);
}

TEST(Walking, StandsAndLooksAroundWithoutMovingItsFeet) {
  ShippedWalkOptions options = Trial("nimbro", "normal");
  options.path.kind = PathKind::kStand;
  options.path.duration_s = 4;
  const WalkTrialResult stand = RunWalkTrial(options);
  EXPECT_TRUE(stand.finished);
  EXPECT_NEAR(stand.end_s, 6, 0.01);
  EXPECT_LT(stand.max_tilt_rad, 0.03);
  EXPECT_LT(stand.end.position.norm(), 0.02);  // the root leans over the middle of the soles, no more
}

TEST(Walking, OdometrySteersBetterThanNothing) {
  // Masses and friction are off: open loop the robot drifts off; its own odometry, with a gyroscope, notices most of
  // that.
  ShippedWalkOptions options = Trial("khr1hv", "normal");
  double error[2] = {0, 0};
  for (const bool odometry : {false, true}) {
    options.path.feedback = odometry ? PathFeedback::kOdometry : PathFeedback::kNone;
    for (options.seed = 1; options.seed <= 2; ++options.seed) {
      const WalkTrialResult walk = RunWalkTrial(options);
      EXPECT_TRUE(walk.finished);
      error[odometry] += std::abs(walk.end.position.y());
    }
  }
  EXPECT_LT(error[1], error[0]);
}

TEST(Walking, TheSameSeedGivesTheSameStateToTheBit) {
  ShippedWalkOptions options = Trial("khr1hv", "normal");
  options.path.length_m = 0.5;
  const WalkTrialResult first = RunWalkTrial(options), second = RunWalkTrial(options);
  EXPECT_EQ(first.last_qpos, second.last_qpos);
  options.seed = 2;
  EXPECT_NE(first.last_qpos, RunWalkTrial(options).last_qpos);
}

TEST(Walking, AServoThatIsTooWeakMakesTheRobotFall) {
  const ShippedWalkOptions options = Trial("khr1hv", "normal");
  Robot robot = ReadShippedRobot("khr1hv");
  for (const RobotLeg& leg : robot.legs) {
    for (const int joint : leg.joints) robot.servos[size_t(joint)].torque_limit = 0.3;
  }
  const WalkTrialResult walk = RunWalkTrial(robot, robot.gaits.at("normal"), options);
  EXPECT_TRUE(walk.fell);
  EXPECT_FALSE(walk.finished);
}

}  // namespace
}  // namespace gaitcam
