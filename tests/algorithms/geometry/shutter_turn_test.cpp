#include "algorithms/geometry/shutter_turn.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

constexpr double kReadout_ms = 20;
constexpr int64_t kStamp_ns = 500'000'000, kGyroPeriod_ns = 5'000'000;

ImuCalibration ObliqueImu() {
  ImuCalibration imu;
  imu.rate_hz = 1e9 / double(kGyroPeriod_ns);
  imu.X_CI = Pose(RotX(0.4) * RotZ(-1.1), Eigen::Vector3d::Zero());
  return imu;
}

/// A head of a brisk walk, rad/s in its own frame.
Eigen::Vector3d Rate_C(double t_s) { return {1.5 * std::sin(20 * t_s), -0.8, 2 * std::cos(20 * t_s)}; }

GyroTurn Measured(int64_t until_ns = 2 * kStamp_ns) {
  GyroTurn gyro(ObliqueImu());
  std::vector<ImuSample> samples;
  for (int64_t t_ns = 0; t_ns <= until_ns; t_ns += kGyroPeriod_ns) {
    ImuSample sample;
    sample.stamp_ns = t_ns;
    sample.angular_rate = ObliqueImu().X_CI.rotation.conjugate() * Rate_C(1e-9 * double(t_ns));
    samples.push_back(sample);
  }
  gyro.Add(samples);
  return gyro;
}

/// R_ST, S at the stamp, T so long after it, in steps of a microsecond.
Eigen::Quaterniond TrueTurn(double after_s) {
  Eigen::Quaterniond R_ST = Eigen::Quaterniond::Identity();
  constexpr double kStep_s = 1e-6;
  const int steps = int(std::lround(std::abs(after_s) / kStep_s));
  for (int i = 0; i < steps; ++i) {
    const double step_s = std::copysign(kStep_s, after_s);
    R_ST = R_ST * ExpSo3(Rate_C(1e-9 * double(kStamp_ns) + (i + 0.5) * step_s) * step_s);
  }
  return R_ST;
}

TEST(ShutterTurn, APointIsPutWhereItWasAtTheStamp) {
  const auto shutter = ShutterTurn::Measure(Measured(), kStamp_ns, kReadout_ms);
  ASSERT_TRUE(shutter);
  for (const double row : {0.0, 0.1, 0.43, 0.5, 0.77, 1.0}) {
    const Eigen::Quaterniond R_ST = TrueTurn(1e-3 * kReadout_ms * (row - 0.5));
    for (const Eigen::Vector2d& at_stamp :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.4, -0.3), Eigen::Vector2d(-0.5, 0.2)}) {
      const Eigen::Vector2d seen = (R_ST.conjugate() * at_stamp.homogeneous()).hnormalized();
      // The rate is taken as constant over each of its periods: by 40 rad/s^2 and half of 5 ms wrong for 2.5 ms.
      EXPECT_LT((shutter->AtStamp(seen, row) - at_stamp).norm(), 3e-4) << row;
      if (row == 0) {
        EXPECT_GT((seen - at_stamp).norm(), 0.01) << "as it was seen";
      }
    }
  }
}

TEST(ShutterTurn, TheCameraTurnsOnWhereTheLastSamplesAreMissing) {
  const auto shutter = ShutterTurn::Measure(Measured(kStamp_ns), kStamp_ns, kReadout_ms);
  ASSERT_TRUE(shutter);
  const Eigen::Vector2d at_stamp(0.4, -0.3);
  const Eigen::Vector2d seen = (TrueTurn(0.5e-3 * kReadout_ms).conjugate() * at_stamp.homogeneous()).hnormalized();
  // 40 rad/s^2 for the 7.5 ms after the last sample's period make 1.1e-3 rad; the point is half a focal length out.
  EXPECT_LT((shutter->AtStamp(seen, 1) - at_stamp).norm(), 2e-3);
  EXPECT_GT((seen - at_stamp).norm(), 0.01) << "as it was seen";
}

TEST(ShutterTurn, WhatTheGyroscopeDidNotMeasureIsNotKnown) {
  EXPECT_FALSE(ShutterTurn::Measure(GyroTurn(ObliqueImu()), kStamp_ns, kReadout_ms));
  EXPECT_FALSE(ShutterTurn::Measure(Measured(kStamp_ns - 3 * kGyroPeriod_ns), kStamp_ns, kReadout_ms)) << "too early";
  EXPECT_FALSE(ShutterTurn::Measure(Measured(), 5 * kStamp_ns, kReadout_ms));
}

}  // namespace
}  // namespace gaitcam
