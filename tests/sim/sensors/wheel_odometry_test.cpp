#include "sim/sensors/wheel_odometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/planar_pose.h"
#include "sim/sensors/sensors.h"
#include "sim/walking/omni_drive.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

OdometryOptions ExactWheels() {
  OdometryOptions options;
  options.wheel_radius_pct = options.wheel_difference_pct = options.wheel_distance_pct = options.slip_per_sqrt_m = 0;
  return options;
}

/// 10 m straight ahead, then a full turn on the spot, read every 5 cm or 1.8 degrees.
struct WayAndTurn {
  PlanarPose way, turn;
};

WayAndTurn Reckon(const OdometryOptions& options, uint64_t seed) {
  Wheels wheels(DriveOptions(), options, false, RandomStream(seed, "wheels"));
  const auto drive = [&](const PlanarPose& step, int readings) {
    PlanarPose reckoned;
    for (int i = 0; i < readings; ++i) {
      for (int k = 0; k < 10; ++k) wheels.Roll(step);
      reckoned = reckoned * wheels.Read();
    }
    return reckoned;
  };
  const PlanarPose way = drive({{0.005, 0}, 0}, 200);
  return {way, drive({{0, 0}, 2 * kPi / 2000}, 200)};
}

TEST(Wheels, WithoutErrorsTheyTellAnyMotionToATick) {
  OdometryOptions options = ExactWheels();
  RandomStream random(3, "motions");
  for (const int ticks : {0, 2048}) {
    options.ticks_per_turn = ticks;
    Wheels wheels(DriveOptions(), options, false, RandomStream(1, "wheels"));
    PlanarPose truth, reckoned;
    for (int i = 0; i < 500; ++i) {
      const PlanarPose step({random.Uniform(-2e-3, 2e-3), random.Uniform(-2e-3, 2e-3)}, random.Uniform(-2e-3, 2e-3));
      for (int k = 0; k < 5; ++k) truth = truth * step, wheels.Roll(step);
      reckoned = reckoned * wheels.Read();
    }
    // A tick is 0.15 mm of a wheel's way; of its rounding two thirds reach the base, 0.3 mrad a tick. What is left
    // without ticks is that a reading of 10 mrad takes an arc for its chord: 1e-2^2 / 24 of a way of 1 cm, 500 times.
    EXPECT_LT((reckoned.position - truth.position).norm(), ticks > 0 ? 2e-3 : 2e-5);
    EXPECT_LT(std::abs(reckoned.heading - truth.heading), ticks > 0 ? 6e-4 : 1e-12);
  }
}

TEST(Wheels, ErrorsOfTheirGeometryScaleWayAndTurnAndBendTheWay) {
  OdometryOptions options = ExactWheels();
  options.ticks_per_turn = 0;
  options.wheel_radius_pct = 1;
  WayAndTurn reckoned = Reckon(options, 7);
  const double scale = reckoned.way.position.x() / 10;
  EXPECT_GT(std::abs(scale - 1), 1e-3);
  EXPECT_NEAR(reckoned.turn.heading / (2 * kPi), scale, 1e-9);
  EXPECT_NEAR(reckoned.way.heading, 0, 1e-12);
  options = ExactWheels();
  options.ticks_per_turn = 0;
  options.wheel_distance_pct = 2;
  reckoned = Reckon(options, 7);
  EXPECT_NEAR(reckoned.way.position.x(), 10, 1e-9);
  EXPECT_GT(std::abs(reckoned.turn.heading / (2 * kPi) - 1), 1e-3);
  options = ExactWheels();
  options.wheel_difference_pct = 0.5;
  EXPECT_GT(std::abs(Reckon(options, 7).way.heading), 1e-2);
}

/// Root mean squares over seeds.
struct WheelSpread {
  double along = 0, heading = 0, turn = 0;
};

WheelSpread WheelSpreadOf(const OdometryOptions& options, int seeds) {
  WheelSpread spread;
  for (int seed = 1; seed <= seeds; ++seed) {
    const WayAndTurn reckoned = Reckon(options, uint64_t(seed));
    spread.along += std::pow(reckoned.way.position.x() - 10, 2) / seeds;
    spread.heading += std::pow(reckoned.way.heading, 2) / seeds;
    spread.turn += std::pow(reckoned.turn.heading - 2 * kPi, 2) / seeds;
  }
  return {std::sqrt(spread.along), std::sqrt(spread.heading), std::sqrt(spread.turn)};
}

TEST(Wheels, DriftIsAsWideAsTheDataSheetSays) {
  constexpr int kSeeds = 400;  // their spread is known to 1 / sqrt(2 n) = 3.5 %; three of that, 11 %
  const OdometryCalibration sheet = WheelDataSheet(DriveOptions(), OdometryOptions());
  const WheelSpread spread = WheelSpreadOf(OdometryOptions(), kSeeds);
  // Straight ahead is along no wheel: 2 / 3 sum_i t_i slip_i is then as wide as in the worst direction.
  EXPECT_NEAR(spread.along / (sheet.position_per_sqrt_m * std::sqrt(10)), 1, 0.11);
  // Of the worst direction's 2 m the wheels roll 2 sin(60 deg) = 1.73 m a metre: slip turns by 7 % less.
  EXPECT_NEAR(spread.heading / (sheet.heading_per_sqrt_m * std::sqrt(10)), 0.96, 0.13);
  EXPECT_NEAR(spread.turn / (sheet.heading_per_sqrt_rad * std::sqrt(2 * kPi)), 1, 0.11);
}

TEST(Wheels, SlipGrowsWithTheRootOfTheWayHoweverOftenItIsRead) {
  OdometryOptions options = ExactWheels();
  options.ticks_per_turn = 0;
  options.slip_per_sqrt_m = 0.01;
  const auto spread_after = [&](double metres, int readings) {
    double squares = 0;
    for (int seed = 1; seed <= 300; ++seed) {
      Wheels wheels(DriveOptions(), options, false, RandomStream(uint64_t(seed), "wheels"));
      double heading = 0;
      for (int i = 0; i < readings; ++i) {
        wheels.Roll({{metres / readings, 0}, 0});
        heading += wheels.Read().heading;
      }
      squares += heading * heading / 300;
    }
    return std::sqrt(squares);
  };
  // Each is known to 1 / sqrt(600) = 4 %, a ratio to 6 %; three of that.
  const double once = spread_after(1, 10);
  EXPECT_NEAR(once, 0.01 * std::sqrt(1.732) / (3 * 0.175), 0.12 * once);
  EXPECT_NEAR(spread_after(1, 100) / once, 1, 0.18);
  EXPECT_NEAR(spread_after(4, 100) / once, 2, 0.36);
}

/// A square of 1 m, driven by physics.
std::vector<OdometrySample> DriveSquare(const SensorOptions& options, uint64_t seed, PlanarPose& truth) {
  const Robot robot = ReadRobot("omni_base", TestData() / "models");
  PathOptions path;
  path.kind = PathKind::kSquare;
  path.side_m = 1;
  OmniDriveOptions drive_options;
  drive_options.speed_mps = 0.5;
  const Pose start(RotZ(0.5), {1, 2, 0});
  World world(robot, Scene(), PhysicsOptions(), {}, 1);
  const auto drive = MakeOmniDrive(robot, drive_options, path, start, 1);
  world.SetState(drive->InitialRoot(), drive->InitialJoints());
  SensorSuite sensors(world, options, seed);
  ControlInput input;
  while (!drive->Finished()) {
    input.stamp_ns = world.stamp_ns();
    world.SetTargets(drive->Update(input));
    for (int i = 0; i < 2; ++i) world.Step(), sensors.Step(world);
    world.record().DropBefore(world.stamp_ns());
  }
  const PlanarPose X_WB(world.X_WB());
  truth = PlanarPose(start).Inverse() * X_WB;
  return sensors.TakeOdometry();
}

TEST(WheelOdometry, PerfectWheelsTellWhereTheBaseHasCome) {
  SensorOptions options;
  options.perfect = true;
  options.odometry.emplace();
  PlanarPose truth;
  const std::vector<OdometrySample> samples = DriveSquare(options, 1, truth);
  ASSERT_GT(samples.size(), 100u);
  EXPECT_EQ(samples[0].stamp_ns, 0);
  EXPECT_TRUE(samples[0].position.isZero(0));
  for (size_t i = 1; i < samples.size(); ++i) EXPECT_EQ(samples[i].stamp_ns, int64_t(i) * 20'000'000);
  // The base stands by then; what is left is the root link's rocking, and arcs read as chords.
  EXPECT_LT((samples.back().position - truth.position).norm(), 1e-3);
  EXPECT_LT(std::abs(WrapAngle(samples.back().heading - truth.heading)), 1e-4);
}

TEST(WheelOdometry, TheSameSeedSlipsAlikeAndAnotherDoesNot) {
  SensorOptions options;
  options.odometry.emplace();
  PlanarPose truth;
  const auto a = DriveSquare(options, 1, truth), b = DriveSquare(options, 1, truth), c = DriveSquare(options, 2, truth);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].position, b[i].position);
    EXPECT_EQ(a[i].heading, b[i].heading);
  }
  EXPECT_NE(a.back().heading, c.back().heading);
}

TEST(WheelOdometry, OthersOfTheRobotsSensorsReadAsWithoutIt) {
  World world(ReadRobot("omni_base", TestData() / "models"), Scene(), PhysicsOptions(), {}, 1);
  SensorOptions with;
  with.odometry.emplace();
  SensorSuite plain(world, SensorOptions(), 1), odometer(world, with, 1);
  for (int i = 0; i < 50; ++i) world.Step(), plain.Step(world), odometer.Step(world);
  EXPECT_EQ(plain.imu().specific_force, odometer.imu().specific_force);
  EXPECT_EQ(plain.ReadJoints(world).position, odometer.ReadJoints(world).position);
  EXPECT_TRUE(plain.TakeOdometry().empty());
}

TEST(WheelOdometry, WhatIsCarriedHasNone) {
  World world(ReadRobot("handheld", TestData() / "models"), Scene(), PhysicsOptions(), {}, 1);
  SensorOptions options;
  options.odometry.emplace();
  EXPECT_THROW(SensorSuite(world, options, 1), BadOption);
  options.odometry->rate_hz = 900;
  World base(ReadRobot("omni_base", TestData() / "models"), Scene(), PhysicsOptions(), {}, 1);
  EXPECT_THROW(SensorSuite(base, options, 1), BadOption) << "more samples than physics steps";
}

}  // namespace
}  // namespace gaitcam
