#include "algorithms/geometry/up_direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

/// An IMU with the camera's axes; -y is up in the camera.
ImuCalibration Imu() {
  ImuCalibration imu;
  imu.rate_hz = 200;
  return imu;
}

std::vector<ImuSample> Still(int count, const Eigen::Vector3d& rate, const Eigen::Vector3d& up) {
  std::vector<ImuSample> samples;
  for (int i = 0; i < count; ++i) samples.push_back({i * 5'000'000LL, rate, 9.81 * up});
  return samples;
}

TEST(UpDirection, ATurnAboutTheVerticalIsHeadingAlone) {
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  UpDirection direction(Imu(), up);
  direction.Add(Still(200, 0.5 * up, up));  // 1 s at 0.5 rad/s to the left
  EXPECT_NEAR(direction.heading_rad(), 0.5, 1e-9);
  EXPECT_NEAR((direction.up_C() - up).norm(), 0, 1e-9);
}

TEST(UpDirection, AWrongStartIsForgottenAtThePullsPace) {
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  UpDirection direction(Imu(), Eigen::Vector3d(0.1, -1, 0), 2.0);
  const double before = std::acos(direction.up_C().dot(up));
  direction.Add(Still(400, Eigen::Vector3d::Zero(), up));  // 2 s: one time constant
  EXPECT_NEAR(std::acos(direction.up_C().dot(up)), before * std::exp(-1), 0.01 * before);
}

TEST(UpDirection, AKnownBiasDoesNotTurnIt) {
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY(), bias(0.01, -0.02, 0.03);
  UpDirection direction(Imu(), up);
  direction.Add(Still(200, bias, up), bias);
  EXPECT_EQ(direction.heading_rad(), 0);
  EXPECT_NEAR((direction.up_C() - up).norm(), 0, 1e-12);
}

TEST(UpDirection, WhatIsTurnedBetweenSamplesThatAreFarApartIsNotForgotten) {
  // A head that nods by 0.1 rad at 1 Hz and turns by 0.5 rad/s; of each 0.25 s the IMU is silent for 0.1 s.
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  const auto nod = [](double t_s) { return 0.1 * std::sin(2 * kPi * t_s); };
  UpDirection direction(Imu(), up);
  double worst_rad = 0, heading_rad = 0;
  for (int i = 1; i <= 1000; ++i) {
    const double t_s = i * 0.005, rate = (nod(t_s) - nod(t_s - 0.005)) / 0.005;
    const Eigen::Vector3d up_C = Eigen::AngleAxisd(-nod(t_s), Eigen::Vector3d::UnitX()) * up;
    if (i % 50 >= 30) continue;
    direction.Add({{i * 5'000'000LL, rate * Eigen::Vector3d::UnitX() + 0.5 * up_C, 9.81 * up_C}});
    heading_rad = 0.5 * t_s;
    worst_rad = std::max(worst_rad, std::acos(std::min(1.0, direction.up_C().dot(up_C))));
  }
  // Linear within 0.1 s, a sine of 1 Hz is wrong by at most a twentieth; forgotten, a silence can cost 0.06 rad, and
  // two fifths of the heading.
  EXPECT_LT(worst_rad, 0.02);
  EXPECT_NEAR(direction.heading_rad(), heading_rad, 0.02 * heading_rad);
}

TEST(UpDirection, WithoutAnImuNothingChanges) {
  UpDirection direction({}, -Eigen::Vector3d::UnitY());
  direction.Add(Still(10, Eigen::Vector3d::Ones(), Eigen::Vector3d::UnitX()));
  EXPECT_EQ(direction.up_C(), -Eigen::Vector3d::UnitY());
}

}  // namespace
}  // namespace gaitcam
