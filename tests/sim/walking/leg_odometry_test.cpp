#include "sim/walking/leg_odometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/planar_pose.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

ShippedWalkOptions OdometryWalk(PathKind path, double seconds) {
  ShippedWalkOptions options;
  options.path.kind = path;
  options.path.length_m = 3;
  options.path.diameter_m = 1;
  options.longest_s = seconds;
  options.sensors.odometry.emplace();
  return options;
}

/// What the legs have wrong in the end.
struct LegError {
  double position_m = 0, heading_rad = 0;
};

LegError LegErrorOf(const WalkTrialResult& walk) {
  const PlanarPose truth = walk.start.Inverse() * walk.end;
  // The last reading is as old as a period of the odometry, in which the trunk moves by some millimetres.
  const OdometrySample& legs = walk.odometry.back();
  return {(legs.position - truth.position).norm(), std::abs(WrapAngle(legs.heading - truth.heading))};
}

TEST(LegOdometry, StaysWithinAFewPerCentOfTheWay) {
  for (const char* robot : {"khr1hv", "nimbro"}) {
    for (const PathKind path : {PathKind::kStraight, PathKind::kCircle}) {
      ShippedWalkOptions options = OdometryWalk(path, 14);
      options.robot = robot;
      const WalkTrialResult walk = RunWalkTrial(options);
      ASSERT_FALSE(walk.fell);
      ASSERT_GT(walk.distance_m, 1.4);
      // Feet slip back by up to 3 % at this gait; the bias of the gyroscope is learnt to 3e-4 rad/s, 0.2 degrees.
      EXPECT_LT(LegErrorOf(walk).position_m, 0.04 * walk.distance_m) << robot << " " << ToWord(path);
      EXPECT_LT(LegErrorOf(walk).heading_rad, 0.01) << robot << " " << ToWord(path);
    }
  }
}

TEST(LegOdometry, TheHeadRocksAboutAsMuchAsTheDataSheetSays) {
  const OdometryCalibration sheet = LegDataSheet(50);
  double tilt2 = 0, height2 = 0;
  int walks = 0;
  for (const char* robot : {"khr1hv", "nimbro", "robovie_m"}) {
    for (const char* gait : {"normal", "brisk"}) {
      ShippedWalkOptions options = OdometryWalk(PathKind::kStraight, 8);
      options.robot = robot;
      options.preset = gait;
      const WalkTrialResult walk = RunWalkTrial(options);
      ASSERT_FALSE(walk.fell) << robot << " " << gait;
      // No gait tilts it by more than twice that: a system that gates by it at three sigmas sees every walk.
      EXPECT_LT(walk.head_tilt_rms.maxCoeff(), 2 * sheet.rocking_rad) << robot << " " << gait;
      EXPECT_LT(walk.head_height_rms_m, 2 * sheet.rocking_m) << robot << " " << gait;
      tilt2 += walk.head_tilt_rms.squaredNorm() / 2;
      height2 += walk.head_height_rms_m * walk.head_height_rms_m;
      ++walks;
    }
  }
  // One sheet for all of them: about either axis, root mean square over gaits.
  EXPECT_NEAR(std::sqrt(tilt2 / walks) / sheet.rocking_rad, 1, 0.35);
  EXPECT_NEAR(std::sqrt(height2 / walks) / sheet.rocking_m, 1, 0.35);
}

TEST(LegOdometry, AnImuOfAnotherRateDoesAsWell) {
  ShippedWalkOptions options = OdometryWalk(PathKind::kCircle, 14);
  for (const double rate_hz : {100.0, 500.0}) {
    options.sensors.imu_rate_hz = rate_hz;
    const WalkTrialResult walk = RunWalkTrial(options);
    // The walker itself reads this IMU and needs it fresh: it may walk worse, but the odometry sees what it does.
    EXPECT_LT(LegErrorOf(walk).position_m, 0.06 * std::max(1.0, walk.distance_m)) << rate_hz;
    EXPECT_LT(LegErrorOf(walk).heading_rad, 0.02) << rate_hz;
  }
}

TEST(LegOdometry, SamplesComeAtTheirRateFromTheFirstReadingOn) {
  ShippedWalkOptions options = OdometryWalk(PathKind::kStraight, 3);
  options.sensors.odometry->rate_hz = 40;
  const std::vector<OdometrySample> samples = RunWalkTrial(options).odometry;
  ASSERT_GE(samples.size(), 119u);
  EXPECT_EQ(samples[0].stamp_ns, 0);
  EXPECT_LT(samples[0].position.norm(), 1e-3);
  for (size_t i = 1; i < samples.size(); ++i) {
    // Joints are read every 4 ms.
    EXPECT_GE(samples[i].stamp_ns, int64_t(i) * 25'000'000);
    EXPECT_LT(samples[i].stamp_ns, int64_t(i) * 25'000'000 + 4'000'000);
  }
}

/// Readings of a robot that steps from one foot to the other on the spot, every 4 ms.
struct Readings {
  std::vector<ImuSample> imu;
  std::vector<JointSample> joints;
};

Readings Treading(const Robot& robot, double seconds) {
  Readings readings;
  for (int i = 0; i < int(250 * seconds); ++i) {
    const int64_t stamp_ns = int64_t(i) * 4'000'000;
    const double t = 1e-9 * double(stamp_ns);
    readings.imu.push_back({stamp_ns, {0.01, -0.01, t < 1 ? 0.02 : 0.12}, {0, 0, 9.81}});
    JointSample joints;
    joints.stamp_ns = stamp_ns;
    joints.position.assign(robot.joints.size(), 0.0);
    joints.left_contact = t < 1 || i / 100 % 2 == 0;
    joints.right_contact = t < 1 || !joints.left_contact;
    readings.joints.push_back(joints);
  }
  return readings;
}

TEST(LegOdometry, ItsHeadingIsTheGyroscopesLessTheBiasLearntAtRest) {
  const Robot robot = ReadShippedRobot("khr1hv");
  LegOdometry legs(robot, 50);
  const Readings readings = Treading(robot, 81);
  const std::vector<OdometrySample> samples = legs.Update(readings.imu, readings.joints);
  // 0.1 rad/s for 80 s, beyond a full turn.
  EXPECT_NEAR(samples.back().heading, 8, 0.01);
}

TEST(LegOdometry, HowReadingsAreHandedOverMakesNoDifference) {
  const Robot robot = ReadShippedRobot("khr1hv");
  LegOdometry at_once(robot, 50), in_parts(robot, 50);
  const Readings readings = Treading(robot, 3);
  const std::vector<OdometrySample> whole = at_once.Update(readings.imu, readings.joints);
  std::vector<OdometrySample> parts;
  size_t imu = 0, joints = 0;
  for (size_t frame = 1; joints < readings.joints.size(); ++frame) {
    // The IMU's come ahead of the joints' by one, as they may where a shutter closes.
    const size_t imu_end = std::min(readings.imu.size(), 8 * frame + 1);
    const size_t joints_end = std::min(readings.joints.size(), 8 * frame);
    for (const OdometrySample& sample :
         in_parts.Update({readings.imu.begin() + long(imu), readings.imu.begin() + long(imu_end)},
                         {readings.joints.begin() + long(joints), readings.joints.begin() + long(joints_end)}))
      parts.push_back(sample);
    imu = imu_end, joints = joints_end;
  }
  ASSERT_EQ(parts.size(), whole.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].stamp_ns, whole[i].stamp_ns);
    EXPECT_EQ(parts[i].position, whole[i].position);
    EXPECT_EQ(parts[i].heading, whole[i].heading);
  }
}

}  // namespace
}  // namespace gaitcam
