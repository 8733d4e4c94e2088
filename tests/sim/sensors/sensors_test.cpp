#include "sim/sensors/sensors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

Robot TestRobot() { return ReadRobot("khr1hv", TestData() / "models"); }

SensorOptions Perfect(double rate_hz) {
  SensorOptions options;
  options.imu_rate_hz = rate_hz;
  options.perfect = true;
  return options;
}

/// Stretched legs on the floor.
World TestRobotStanding() { return World(TestRobot(), Scene(), PhysicsOptions(), {}, 1); }

/// In the air, turning and with all joints moving.
World Tumbling() {
  World world = TestRobotStanding();
  const Robot& robot = world.robot();
  std::vector<double> joints(robot.joints.size(), 0.0);
  for (size_t i = 0; i < joints.size(); ++i) joints[i] = 0.2 * std::sin(double(i));
  world.SetState(Pose(RotX(0.3), {0, 0, 2}), joints);
  world.data()->qvel[3] = 2, world.data()->qvel[4] = -1.5, world.data()->qvel[5] = 3;
  mj_forward(world.model(), world.data());
  world.SetTargets(std::vector<double>(world.target_count(), 0.0));
  return world;
}

TEST(WindowMean, AveragesOverWindowsCentredOnMultiplesOfThePeriod) {
  WindowMean mean(300);  // windows of 3333333.3 ns that start at -1666667 ns
  EXPECT_EQ(mean.until_ns(), -1666667);
  mean.Extend(0, {1, 0, 0});
  mean.Extend(1000000, {4, 0, 0});
  EXPECT_FALSE(mean.Take().has_value());
  mean.Extend(10000000, {7, 1, 0});
  // 1 for 1666667 ns, 4 for 1000000 ns, 7 for the remaining 666667 ns.
  EXPECT_NEAR(mean.Take()->x(), (1 * 1666667 + 4 * 1e6 + 7 * 666667) / 3333334.0, 1e-12);
  EXPECT_NEAR(mean.Take()->x(), 7, 1e-12);
  EXPECT_NEAR(mean.Take()->y(), 1, 1e-12);
  EXPECT_FALSE(mean.Take().has_value());
}

TEST(Sensors, AtRestAPerfectImuReadsGravityAlone) {
  World world = TestRobotStanding();
  SensorSuite sensors(world, Perfect(250), 1);
  EXPECT_LT((sensors.imu().specific_force - Eigen::Vector3d(0, 0, 9.81)).norm(), 1e-12);
  while (world.stamp_ns() < 1000000000) world.Step(), sensors.Step(world);
  // Half a second after the first touch, contacts still creep by less than 1 mm/s^2 and 0.1 mrad/s.
  EXPECT_LT((sensors.imu().specific_force - Eigen::Vector3d(0, 0, 9.81)).norm(), 1e-2);
  EXPECT_LT(sensors.imu().angular_rate.norm(), 1e-3);
}

TEST(Sensors, StampsFollowTheRateAndArriveSoon) {
  for (double rate : {500.0, 250.0, 200.0, 130.0}) {
    World world = TestRobotStanding();
    SensorSuite sensors(world, Perfect(rate), 1);
    std::vector<ImuSample> samples;
    for (int i = 0; i < 500; ++i) {
      world.Step();
      sensors.Step(world);
      for (const ImuSample& sample : sensors.TakeImu()) {
        EXPECT_EQ(sample.stamp_ns, std::llround(double(samples.size()) * 1e9 / rate));
        // Half a period and half a physics step of averaging, then the next step of 2 ms.
        EXPECT_LE(double(world.stamp_ns() - sample.stamp_ns), 0.5e9 / rate + 3e6 + 1);
        samples.push_back(sample);
      }
    }
    EXPECT_NEAR(double(samples.size()), rate, 2);
  }
}

TEST(Sensors, PerfectGyroAddsUpToTheTrueRotation) {
  World world = Tumbling();
  SensorSuite sensors(world, Perfect(200), 1);
  Eigen::Quaterniond integrated = Eigen::Quaterniond::Identity(), at_first = integrated, truth = integrated;
  int64_t last = -1;
  MjDataPtr scratch(mj_makeData(world.model()));
  const auto rotation = [&](int64_t stamp) {
    world.record().Evaluate(world.model(), stamp, scratch.get());
    return Eigen::Quaterniond(scratch->qpos[3], scratch->qpos[4], scratch->qpos[5], scratch->qpos[6]);
  };
  while (world.stamp_ns() < 400000000) {
    world.Step();
    sensors.Step(world);
    for (const ImuSample& sample : sensors.TakeImu()) {
      const int64_t end = sample.stamp_ns + 2500000;  // of the window
      if (last >= 0) {
        const Eigen::Vector3d turn = sample.angular_rate * 5e-3;
        integrated = integrated * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      } else {
        at_first = rotation(end);
      }
      last = end;
    }
  }
  truth = at_first.conjugate() * rotation(last);
  ASSERT_GT(RotationAngle(Eigen::Quaterniond::Identity(), truth), 1.0);
  // Within a window the axis changes between physics steps (coning); over 80 windows that stays below 0.1 mrad.
  EXPECT_LT(RotationAngle(integrated, truth), 1e-4);
}

TEST(Sensors, PerfectAccelerometerAddsUpToTheTrueVelocity) {
  World world = Tumbling();
  SensorSuite sensors(world, Perfect(250), 1);
  const int site = mj_name2id(world.model(), mjOBJ_SITE, "imu");
  MjDataPtr scratch(mj_makeData(world.model()));
  const auto imu_pose = [&](int64_t stamp) {
    world.record().Evaluate(world.model(), stamp, scratch.get());
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(scratch->site_xmat + 9 * site);
    return Pose(Eigen::Matrix3d(R), Eigen::Map<const Eigen::Vector3d>(scratch->site_xpos + 3 * site));
  };
  const auto velocity = [&](int64_t stamp) {  // of the step around the stamp, which is the middle of a physics step
    return Eigen::Vector3d((imu_pose(stamp + 900000).translation - imu_pose(stamp - 900000).translation) / 1.8e-3);
  };
  Eigen::Vector3d change = Eigen::Vector3d::Zero(), first = change;
  int64_t begin = -1, end = -1;
  for (int i = 0; i < 120; ++i) {
    world.Step();
    sensors.Step(world);
    for (const ImuSample& sample : sensors.TakeImu()) {
      if (sample.stamp_ns < 12000000) continue;
      if (begin < 0) begin = sample.stamp_ns - 2000000;
      end = sample.stamp_ns + 2000000;
      change += (imu_pose(sample.stamp_ns).R() * sample.specific_force - Eigen::Vector3d(0, 0, 9.81)) * 4e-3;
    }
  }
  // Windows end at physics steps, where the recorded velocity jumps: take the mean of both sides.
  const auto mean_velocity = [&](int64_t stamp) {
    return Eigen::Vector3d(0.5 * (velocity(stamp - 1000000) + velocity(stamp + 1000000)));
  };
  first = mean_velocity(begin);
  const Eigen::Vector3d truth = mean_velocity(end) - first;
  ASSERT_GT(truth.norm(), 1.5);  // mostly 0.2 s of free fall
  // Turning by 3 rad/s within windows of 4 ms, and joint accelerations that change within them: 2 mm/s.
  EXPECT_LT((change - truth).norm(), 0.005);
}

TEST(Sensors, NoiseIsThatOfTheDataSheet) {
  World world = TestRobotStanding();
  while (world.stamp_ns() < 1000000000) world.Step();  // settled
  SensorOptions options;
  options.gyro_bias = options.accel_bias = 0;
  options.gyro_random_walk = options.accel_random_walk = 0;
  SensorSuite sensors(world, options, 9);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = sum, force_sum = sum, force_squares = sum;
  const int n = 4000;
  int count = 0;
  while (count < n) {
    world.Step();
    sensors.Step(world);
    for (const ImuSample& sample : sensors.TakeImu()) {
      sum += sample.angular_rate;
      squares += sample.angular_rate.cwiseAbs2();
      force_sum += sample.specific_force;
      force_squares += sample.specific_force.cwiseAbs2();
      ++count;
    }
  }
  const double gyro_sigma = options.gyro_noise_density * std::sqrt(options.imu_rate_hz);
  const double accel_sigma = options.accel_noise_density * std::sqrt(options.imu_rate_hz);
  for (int i = 0; i < 3; ++i) {
    // A standard deviation from 4000 samples is uncertain by 1 / sqrt(8000) = 1.1 %; four times that.
    EXPECT_NEAR(std::sqrt(squares[i] / n - std::pow(sum[i] / n, 2)) / gyro_sigma, 1, 0.045);
    EXPECT_NEAR(std::sqrt(force_squares[i] / n - std::pow(force_sum[i] / n, 2)) / accel_sigma, 1, 0.045);
  }
}

TEST(Sensors, BiasWalksAsStated) {
  // Over many short runs, the bias after time T has standard deviation b sqrt(T) per axis.
  SensorOptions options;
  options.gyro_noise_density = options.accel_noise_density = 0;
  options.gyro_bias = options.accel_bias = 0;
  options.gyro_random_walk = 0.1;
  World world = TestRobotStanding();
  while (world.stamp_ns() < 1000000000) world.Step();
  std::vector<SensorSuite> suites;
  for (uint64_t seed = 0; seed < 100; ++seed) suites.emplace_back(world, options, seed);
  for (int i = 0; i < 100; ++i) {
    world.Step();
    for (SensorSuite& suite : suites) suite.Step(world);
  }
  double squares = 0;
  for (const SensorSuite& suite : suites) squares += suite.imu().angular_rate.squaredNorm();
  // 300 values give the deviation to 4 %; three times that.
  const double seconds = double(suites[0].imu().stamp_ns) * 1e-9 - 1;
  EXPECT_NEAR(std::sqrt(squares / 300) / (0.1 * std::sqrt(seconds)), 1, 0.13);
}

TEST(Sensors, SameSeedSameReadings) {
  World world = TestRobotStanding();
  SensorSuite a(world, SensorOptions(), 4), b(world, SensorOptions(), 4), c(world, SensorOptions(), 5);
  for (int i = 0; i < 20; ++i) world.Step(), a.Step(world), b.Step(world), c.Step(world);
  EXPECT_EQ(a.imu().angular_rate, b.imu().angular_rate);
  EXPECT_NE(a.imu().angular_rate, c.imu().angular_rate);
  EXPECT_EQ(a.ReadJoints(world).position, b.ReadJoints(world).position);
}

TEST(Sensors, EncodersRoundAndFootSwitchesClose) {
  World world = TestRobotStanding();
  for (int i = 0; i < 100; ++i) world.Step();
  SensorOptions options;
  options.encoder_noise = 0;
  options.encoder_resolution = 0.01;
  SensorSuite coarse(world, options, 1), perfect(world, Perfect(250), 1);
  const std::vector<double> truth = world.JointPositions();
  EXPECT_EQ(perfect.ReadJoints(world).position, truth);
  const JointSample sample = coarse.ReadJoints(world);
  EXPECT_EQ(sample.stamp_ns, world.stamp_ns());
  EXPECT_TRUE(sample.left_contact && sample.right_contact);
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(sample.position[i], truth[i], 0.005 + 1e-12);
    EXPECT_NEAR(std::remainder(sample.position[i], 0.01), 0, 1e-12);
  }
  World air = Tumbling();
  air.Step();
  EXPECT_FALSE(coarse.ReadJoints(air).left_contact || coarse.ReadJoints(air).right_contact);
}

TEST(Sensors, CalibrationLeadsFromImuToCamera) {
  const Robot robot = TestRobot();
  std::vector<double> joints(robot.joints.size(), 0.0);
  const Pose X_MC(RotY(0.2), {0.03, 0, 0});
  const ImuCalibration calibration = CalibrateImu(robot, SensorOptions(), X_MC, joints);
  // khr1hv: IMU at (0, 0, 0.045), camera at (0.040, 0, 0.171) of the trunk, optical axes x right, y down, z forward.
  const Pose X_RM(Eigen::Matrix3d(RotZ(-M_PI / 2) * RotX(-M_PI / 2)), {0.04, 0, 0.171});
  const Eigen::Vector3d expected = (X_RM * X_MC).Inverse() * Eigen::Vector3d(0, 0, 0.045);
  EXPECT_LT((calibration.X_CI.translation - expected).norm(), 1e-9);
  EXPECT_EQ(calibration.rate_hz, 250);
  EXPECT_EQ(calibration.gyro_noise_density, SensorOptions().gyro_noise_density);
  EXPECT_EQ(CalibrateImu(robot, Perfect(250), X_MC, joints).gyro_noise_density, 0);
  joints[robot.neck_tilt] = 0.3;  // the camera turns down, so that the IMU is seen turned up
  EXPECT_NEAR(
      RotationAngle(CalibrateImu(robot, SensorOptions(), X_MC, joints).X_CI.rotation, calibration.X_CI.rotation), 0.3,
      1e-9);
}

TEST(Sensors, RateBeyondThePhysicsIsRefused) {
  World world = TestRobotStanding();
  EXPECT_NO_THROW(SensorSuite(world, Perfect(500), 1));
  EXPECT_THROW(SensorSuite(world, Perfect(501), 1), BadOption);
}

}  // namespace
}  // namespace gaitcam
