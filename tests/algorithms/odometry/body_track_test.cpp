#include "algorithms/odometry/body_track.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

OdometryCalibration CameraOnAMast() {
  OdometryCalibration calibration;
  calibration.rate_hz = 50;
  // 10 cm before the middle of the base, 1.3 m over the floor, looking ahead.
  calibration.X_BC = Pose(Eigen::Matrix3d(RotZ(-M_PI / 2) * RotX(-M_PI / 2)), {0.1, 0, 1.3});
  calibration.position_per_sqrt_m = 0.01;
  calibration.heading_per_sqrt_m = 0.002;
  calibration.heading_per_sqrt_rad = 0.01;
  return calibration;
}

constexpr int64_t kPeriod_ns = 20'000'000;

/// Round an arc at 0.5 m/s and 0.4 rad/s, which even motion between samples nearly is.
PlanarPose Arc(double t_s) {
  const double heading = 0.4 * t_s, radius = 0.5 / 0.4;
  return {{radius * std::sin(heading), radius * (1 - std::cos(heading))}, heading};
}

BodyTrack Driven(double seconds) {
  BodyTrack track(CameraOnAMast());
  for (int64_t t = 0; double(t) * 1e-9 <= seconds; t += kPeriod_ns) {
    const PlanarPose body = Arc(double(t) * 1e-9);
    track.Add({{t, body.position, body.heading}});
  }
  return track;
}

TEST(BodyTrack, MovesTheCameraAsTheBodyMoves) {
  const BodyTrack track = Driven(3);
  const Pose& X_BC = CameraOnAMast().X_BC;
  for (const auto& [from_s, to_s] : {std::pair{0.0, 3.0}, {0.313, 1.777}, {1.0, 1.0}, {2.0, 0.5 + 1.501}}) {
    const auto moved = track.Between(std::llround(from_s * 1e9), std::llround(to_s * 1e9));
    ASSERT_TRUE(moved);
    const Pose X_FT = (Arc(from_s).Lifted() * X_BC).Inverse() * (Arc(to_s).Lifted() * X_BC);
    // The chord of 8 mrad between two samples lies 10 um off the arc.
    EXPECT_LT(Minus(moved->X_FT, X_FT).norm(), 5e-5) << from_s << " to " << to_s;
  }
}

/// A head that nods by 3 degrees four times in three seconds while its body goes on, and a gyroscope in it.
BodyTrack Nodding(OdometryCalibration calibration, double rocking_rad) {
  ImuCalibration imu;
  imu.rate_hz = 500;
  calibration.rocking_rad = rocking_rad;
  BodyTrack track(calibration, imu);
  for (int64_t t = 0; t <= 3'000'000'000; t += kPeriod_ns) {
    track.Add({{t, {0.2e-9 * double(t), 0}, 0}});
  }
  for (int64_t t = 0; t <= 3'000'000'000; t += 2'000'000) {
    const double omega = 2 * M_PI * 4 / 3;
    track.Add({}, {{t, {0.052 * omega * std::cos(omega * 1e-9 * double(t)), 0, 0}, {0, 0, 9.81}}});
  }
  return track;
}

TEST(BodyTrack, TheGyroscopeTellsHowARockingHeadTurns) {
  const auto nod = [](double t_s) { return 0.052 * std::sin(2 * M_PI * 4 / 3 * t_s); };
  const BodyTrack legs = Nodding(CameraOnAMast(), 0.04);
  const auto moved = legs.Between(1'000'000'000, 1'250'000'000);
  ASSERT_TRUE(moved);
  // Sums of a rate at 500 Hz: of second order in the period, some 1e-6 rad; half a period at either end.
  EXPECT_NEAR(LogSo3(moved->X_FT.rotation).x(), nod(1.25) - nod(1.0), 1e-4);
  const double sigma = std::sqrt(moved->covariance(3, 3));
  EXPECT_LT(sigma, 0.0052) << "0.02 rad/s over 0.25 s";
  EXPECT_GT(sigma, 0.0049);
  EXPECT_GT(std::sqrt(moved->covariance(1, 1)), 0.002) << "rocking still moves it";
  // Over 2.5 s its bias may have turned it by more than it rocks.
  const auto longer = legs.Between(0, 2'500'000'000);
  EXPECT_EQ(LogSo3(longer->X_FT.rotation).norm(), 0);
  EXPECT_GT(std::sqrt(longer->covariance(3, 3)), 0.039);
}

TEST(BodyTrack, WheelsKnowTheirTurnThemselves) {
  const BodyTrack wheels = Nodding(CameraOnAMast(), OdometryCalibration().rocking_rad);
  const auto moved = wheels.Between(1'000'000'000, 1'100'000'000);
  EXPECT_EQ(LogSo3(moved->X_FT.rotation).norm(), 0);
}

TEST(BodyTrack, KnowsNothingOfWhatItDidNotSee) {
  EXPECT_FALSE(BodyTrack(CameraOnAMast()).Between(0, 1));
  const BodyTrack track = Driven(1);
  EXPECT_FALSE(track.Between(-1, 500'000'000));
  EXPECT_TRUE(track.Between(0, 1'000'000'000 + 2 * kPeriod_ns)) << "a little beyond, as the exposure's middle may be";
  EXPECT_FALSE(track.Between(0, 1'000'000'000 + 3 * kPeriod_ns));
}

TEST(BodyTrack, ForgetsNoMoreThanItIsTold) {
  BodyTrack track = Driven(2);
  const auto before = track.Between(1'010'000'000, 1'900'000'000);
  track.Forget(1'010'000'000);
  const auto after = track.Between(1'010'000'000, 1'900'000'000);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(Minus(before->X_FT, after->X_FT).norm(), 0);
  EXPECT_FALSE(track.Between(500'000'000, 1'900'000'000));
}

TEST(BodyTrack, ErrorsGrowWithTheWayAndTheTurn) {
  const BodyTrack track = Driven(8);
  const auto sigma = [&](double to_s) {
    const auto moved = track.Between(0, std::llround(to_s * 1e9));
    // The body's yaw is a turn about the camera's vertical, y.
    return std::sqrt(moved->covariance(4, 4));
  };
  // 1 m and 0.8 rad: sqrt(0.002^2 + 0.01^2 * 0.8) rad; what is known no better than, 1e-4, is less than a thousandth.
  EXPECT_NEAR(sigma(2), std::sqrt(0.002 * 0.002 + 0.01 * 0.01 * 0.8), 1e-5);
  EXPECT_NEAR(sigma(8) / sigma(2), 2, 1e-3);
}

}  // namespace
}  // namespace gaitcam
