#include "sim/walking/hand_sway.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "sim/walking/omni_drive.h"
#include "sim/world/world.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

constexpr double kPeriod_s = 0.02, kSpeed_mps = 1.2;

/// Where the camera was every `kPeriod_s` of a walk straight on, after it has sped up.
std::vector<Pose> CameraOf(const Robot& robot, uint64_t seed, double speed_mps = kSpeed_mps) {
  OmniDriveOptions options;
  options.speed_mps = speed_mps;
  options.acceleration_mps2 = 3;
  PathOptions path;
  path.length_m = 22 * speed_mps;
  World world(robot, Scene(), PhysicsOptions(), {{"camera", Pose()}}, seed);
  const auto drive = MakeOmniDrive(robot, options, path, Pose(), seed);
  world.SetState(drive->InitialRoot(), drive->InitialJoints());
  std::vector<Pose> poses;
  ControlInput input;
  while (poses.size() < 900) {
    input.stamp_ns = world.stamp_ns();
    world.SetTargets(drive->Update(input));
    world.Step();
    world.Step();
    world.record().DropBefore(world.stamp_ns());
    if (world.stamp_ns() < 2'500'000'000 || world.stamp_ns() % int64_t(kPeriod_s * 1e9) != 0) continue;
    const double* at = world.data()->cam_xpos;
    const double* turned = world.data()->cam_xmat;
    const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(turned);
    poses.push_back({R, Eigen::Vector3d(at[0], at[1], at[2])});
  }
  return poses;
}

std::vector<double> Heights(const std::vector<Pose>& poses) {
  std::vector<double> heights;
  for (const Pose& pose : poses) heights.push_back(pose.translation.z());
  return heights;
}

std::vector<double> Sides(const std::vector<Pose>& poses) {
  std::vector<double> sides;
  for (const Pose& pose : poses) sides.push_back(pose.translation.y());
  return sides;
}

/// Amplitude of a signal's part of one frequency.
double AmplitudeAt(double frequency_hz, const std::vector<double>& signal) {
  std::complex<double> sum = 0;
  double mean = 0, weights = 0;
  for (const double value : signal) mean += value / double(signal.size());
  for (size_t i = 0; i < signal.size(); ++i) {
    const double window = 0.5 - 0.5 * std::cos(2 * M_PI * (double(i) + 0.5) / double(signal.size()));
    sum += window * (signal[i] - mean) * std::polar(1.0, -2 * M_PI * frequency_hz * double(i) * kPeriod_s);
    weights += window;
  }
  return 2 * std::abs(sum) / weights;
}

/// The strongest frequency from 0.5 Hz on: below, the hand strays.
double PeakOf(const std::vector<double>& signal) {
  double best_hz = 0, best = 0;
  for (double hz = 0.5; hz < 5; hz += 0.01) {
    const double amplitude = AmplitudeAt(hz, signal);
    if (amplitude > best) best = amplitude, best_hz = hz;
  }
  return best_hz;
}

class HandheldCamera : public testing::Test {
 protected:
  const Robot robot_ = ReadRobot("handheld", TestData() / "models");
};

TEST_F(HandheldCamera, RisesAndFallsWithEachStepAndGoesToAndFroWithEverySecond) {
  for (const double speed : {0.6, kSpeed_mps}) {
    const double steps_hz = HandSway(robot_, speed, 1).step_rate_hz();
    EXPECT_NEAR(steps_hz, std::sqrt(speed / 0.39), 1e-12);
    const std::vector<Pose> poses = CameraOf(robot_, 1, speed);
    // 18 s tell frequencies to some hundredths of a hertz.
    EXPECT_NEAR(PeakOf(Heights(poses)), steps_hz, 0.03) << speed;
    EXPECT_NEAR(PeakOf(Sides(poses)), steps_hz / 2, 0.03) << speed;
    // The hand's servo of 8 Hz follows to a tenth; turning the wrist adds millimetres.
    EXPECT_NEAR(AmplitudeAt(steps_hz, Heights(poses)), 0.0195, 0.003) << speed;
    EXPECT_NEAR(AmplitudeAt(steps_hz / 2, Sides(poses)), 0.026, 0.005) << speed;
  }
}

TEST_F(HandheldCamera, IsHeldAsHighAsAChestAndNeverLetDown) {
  for (const Pose& pose : CameraOf(robot_, 3)) {
    EXPECT_NEAR(pose.translation.z(), 1.45, 0.1);
    // MuJoCo's cameras look along their -z; five deviations of the hand's aim.
    EXPECT_GT((pose.rotation * -Eigen::Vector3d::UnitZ()).x(), std::cos(0.35));
  }
}

TEST_F(HandheldCamera, OneSeedIsOneMotionToTheBitAndAnotherSeedAnother) {
  const std::vector<Pose> a = CameraOf(robot_, 1), b = CameraOf(robot_, 1), c = CameraOf(robot_, 2);
  double apart_m = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].Matrix(), b[i].Matrix()) << i;
    apart_m = std::max(apart_m, (a[i].translation - c[i].translation).norm());
  }
  EXPECT_GT(apart_m, 0.05);
}

TEST_F(HandheldCamera, StandsAsStillAsAHandDoesWhereNobodyWalks) {
  const HandSway sway(robot_, kSpeed_mps, 1);
  std::vector<double> before(robot_.joints.size(), 0.0);
  sway.AddTo(before, 10, 0);
  for (double t = 10; t < 20; t += 0.01) {
    std::vector<double> now(robot_.joints.size(), 0.0);
    sway.AddTo(now, t, 0);
    for (size_t i = 0; i < now.size(); ++i) EXPECT_LT(std::abs(now[i] - before[i]), 2e-3);
    before = now;
  }
}

TEST(HandSway, ARobotWithoutSwayHasNone) {
  const HandSway sway(ReadRobot("omni_base", TestData() / "models"), 1, 1);
  std::vector<double> targets(3, 0.5);
  sway.AddTo(targets, 7, 1);
  EXPECT_EQ(targets, std::vector<double>(3, 0.5));
}

}  // namespace
}  // namespace gaitcam
