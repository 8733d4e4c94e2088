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
