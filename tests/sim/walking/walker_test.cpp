#include "sim/walking/walker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "algorithms/core/errors.h"
#include "sim/walking/leg_kinematics.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

/// A robot and its nominal model on an empty floor.
class WalkerTest : public testing::Test {
 protected:
  WalkerTest() : robot_(ReadShippedRobot("khr1hv")), world_(robot_, Scene{}, PhysicsOptions{}, {}, 1) {}

  /// What CheckGait says of the `normal` gait after a change, or "".
  template <class Change>
  std::string Complaint(Change change, PathKind path_kind = PathKind::kStraight) {
    GaitOptions gait = robot_.gaits.at("normal");
    change(gait);
    PathOptions path;
    path.kind = path_kind;
    try {
      CheckGait(robot_, world_.nominal_model(), gait, path, {});
      return "";
    } catch (const BadOption& error) {
      return error.what();
    }
  }

  std::unique_ptr<Controller> Make(const PathOptions& path, const Pose& start = {}) {
    return MakeWalker(robot_, world_.nominal_model(), robot_.gaits.at("normal"), path, {}, start);
  }

  ControlInput AtRest(const Controller& walker) const {
    ControlInput input;
    input.imu.specific_force = {0, 0, 9.81};
    input.joints.position = walker.InitialJoints();
    input.X_WB = walker.InitialRoot();
    return input;
  }

  Robot robot_;
  World world_;
};

TEST_F(WalkerTest, AcceptsEveryPresetOfEveryHumanoid) {
  for (const char* name : {"khr1hv", "khr1hv_pan", "robovie_m", "nimbro"}) {
    const Robot robot = ReadShippedRobot(name);
    const World world(robot, Scene{}, PhysicsOptions{}, {}, 1);
    for (const auto& [preset, gait] : robot.gaits) {
      PathOptions path;
      path.kind = PathKind::kSquare;
      EXPECT_NO_THROW(CheckGait(robot, world.nominal_model(), gait, path, {})) << name << " " << preset;
    }
  }
}

TEST_F(WalkerTest, RefusesAStepTooLongForTheLegsAndNamesTheLimit) {
  const std::string complaint = Complaint([](GaitOptions& g) { g.step_length_m = 0.2; });
  EXPECT_THAT(complaint, MatchesRegex("gait.step_length_m: 0.2 exceeds 0\\.[0-9]+, the reach of khr1hv's legs at "
                                      "crouch 0\\.[0-9]+ m"));
  // The limit that it names is one: just below it walks, just above it does not.
  const double limit = std::stod(complaint.substr(complaint.find("exceeds ") + 8));
  EXPECT_EQ(Complaint([&](GaitOptions& g) { g.step_length_m = 0.99 * limit; }), "");
  EXPECT_NE(Complaint([&](GaitOptions& g) { g.step_length_m = 1.02 * limit; }), "");
}

TEST_F(WalkerTest, CountsTheLongerStepsOfAnAsymmetricGait) {
  const auto long_steps = [](GaitOptions& g) { g.step_length_m = 0.06; };
  EXPECT_EQ(Complaint(long_steps), "");
  EXPECT_THAT(Complaint([&](GaitOptions& g) {
                long_steps(g);
                g.asymmetry_ratio = 0.5;
                g.crouch_m = 0.006;
              }),
              HasSubstr("gait.step_length_m: 0.06 exceeds"));
}

TEST_F(WalkerTest, RefusesWhatElseTheLegsCannotDo) {
  EXPECT_THAT(Complaint([](GaitOptions& g) { g.lift_m = 0.15; }), HasSubstr("gait.lift_m: 0.15 exceeds 0."));
  EXPECT_THAT(Complaint([](GaitOptions& g) { g.crouch_m = 0.001; }), HasSubstr("gait.crouch_m: 0.001 is below 0."));
  EXPECT_THAT(Complaint([](GaitOptions& g) { g.crouch_m = 0.12; }), HasSubstr("gait.crouch_m: 0.12 is above 0."));
  EXPECT_THAT(Complaint([](GaitOptions& g) { g.foot_spacing_m = 0.4; }),
              HasSubstr("gait.foot_spacing_m: 0.4 is out of"));
}

TEST_F(WalkerTest, RefusesFeetThatTouchAndMoreSoWhereThePathTurns) {
  const auto narrow = [](GaitOptions& g) { g.foot_spacing_m = 0.05; };
  EXPECT_THAT(Complaint(narrow), HasSubstr("gait.foot_spacing_m: 0.05 is below 0.056, where khr1hv's feet touch"));
  const auto tight = [](GaitOptions& g) { g.foot_spacing_m = 0.06; };
  EXPECT_EQ(Complaint(tight), "");
  EXPECT_THAT(Complaint(tight, PathKind::kSquare), HasSubstr("touch while turning"));
}

TEST_F(WalkerTest, RefusesAPeriodThatTheControlCannotResolve) {
  EXPECT_THAT(Complaint([](GaitOptions& g) { g.period_s = 0.1, g.double_support_ratio = 0.7; }),
              HasSubstr("gait.period_s: 0.1 is below 0.133, 10 control periods"));
}

TEST_F(WalkerTest, ReadsItsGainsFromTheRobotsFile) {
  robot_.control = {{"dcm_gain", 0.125}};
  EXPECT_EQ(ReadWalkerOptions(robot_).dcm_gain, 0.125);
  EXPECT_EQ(ReadWalkerOptions(robot_).roll_gain, WalkerOptions{}.roll_gain);
  robot_.control = {{"dcm_gian", 0.125}};
  try {
    ReadWalkerOptions(robot_);
    FAIL() << "an unknown gain was accepted";
  } catch (const BadInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("khr1hv.yaml: control.dcm_gian: unknown key; did you mean dcm_gain?"));
  }
  robot_.control = {{"dcm_gain", -1}};
  EXPECT_THROW(ReadWalkerOptions(robot_), BadOption);
}

TEST_F(WalkerTest, BeginsUprightWithBothSolesOnTheFloorAtItsStart) {
  const Pose start(RotZ(0.7), Eigen::Vector3d(1, -2, 0));
  const auto walker = Make({}, start);
  const Pose X_WB = walker->InitialRoot();
  EXPECT_NEAR(X_WB.Yaw(), 0.7, 1e-12);
  EXPECT_NEAR(X_WB.R()(2, 2), 1, 1e-12);
  for (const int side : {0, 1}) {
    const LegKinematics leg(robot_, side);
    const Eigen::Vector3d sole = X_WB * (leg.Forward(leg.FromJoints(walker->InitialJoints())) * leg.sole());
    EXPECT_NEAR(sole.z(), 0, 1e-9);
    EXPECT_LT((sole.head<2>() - start.translation.head<2>()).norm(), 0.06);
  }
}

TEST_F(WalkerTest, StandsStillBeforeItWalks) {
  PathOptions path;
  path.settle_s = 0.5;
  const auto walker = Make(path);
  for (int tick = 0; tick < 120; ++tick) {
    walker->Update(AtRest(*walker));
    ASSERT_EQ(walker->gait().step, -1);
    ASSERT_EQ(walker->gait().support, SupportPhase::kDouble);
  }
  for (int tick = 0; tick < 60; ++tick) walker->Update(AtRest(*walker));
  EXPECT_EQ(walker->gait().step, 0);  // 0.72 s: in the first step, whose double support ends after 0.07 s
  EXPECT_EQ(walker->gait().support, SupportPhase::kRight);
}

TEST_F(WalkerTest, StandingPansTheNeckAndEnds) {
  PathOptions path;
  path.kind = PathKind::kStand;
  path.duration_s = 4;
  path.pan_amplitude_rad = 0.4;
  const auto walker = Make(path);
  double left = 0, right = 0, seconds = 0;
  while (!walker->Finished()) {
    const double pan = walker->Update(AtRest(*walker))[size_t(robot_.neck_pan)];
    left = std::max(left, pan);
    right = std::min(right, pan);
    seconds += 0.004;
    ASSERT_LT(seconds, 10);
  }
  EXPECT_NEAR(left, 0.4, 1e-3);
  EXPECT_NEAR(right, -0.4, 1e-3);
  EXPECT_NEAR(seconds, 6, 0.01);
}

TEST_F(WalkerTest, TiltedTrunkIsAnsweredByTheStandingAnkles) {
  const auto upright = Make({});
  const auto tilted = Make({});
  ControlInput input = AtRest(*upright);
  const double rested = upright->Update(input)[size_t(robot_.legs[0].joints[5])];
  input.imu.angular_rate = {0.5, 0, 0};  // falling to the right
  const double answer = tilted->Update(input)[size_t(robot_.legs[0].joints[5])];
  EXPECT_GT(answer, rested + 0.005);  // rolls the trunk back: half the weight, 0.03 s of the rate
}

TEST(WalkingTime, IsThatOfTheStepsAndOfStanding) {
  GaitOptions gait;
  PathOptions path;
  path.length_m = 1.0;
  path.settle_s = 1.0;
  // 25 whole steps of 0.35 s, some more for the ramps and one to close the feet.
  EXPECT_NEAR(EstimateWalkingTime(gait, path), 2 + 30 * 0.35, 3 * 0.35);
  path.kind = PathKind::kStand;
  path.duration_s = 7;
  EXPECT_DOUBLE_EQ(EstimateWalkingTime(gait, path), 9);
}

}  // namespace
}  // namespace gaitcam
