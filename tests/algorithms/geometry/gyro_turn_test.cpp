#include "algorithms/geometry/gyro_turn.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/clock.h"
#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

constexpr int64_t kPeriod_ns = 5'000'000;

ImuCalibration TurnedImu() {
  ImuCalibration imu;
  imu.rate_hz = 200;
  imu.X_CI = Pose(RotX(0.4) * RotZ(-1.1), Eigen::Vector3d::Zero());
  return imu;
}

/// Samples from `first` to before `end`, of a camera that turns by `rate_C` rad/s in its own frame.
std::vector<ImuSample> Samples(const Eigen::Vector3d& rate_C, int first, int end) {
  std::vector<ImuSample> samples;
  for (int i = first; i < end; ++i) {
    ImuSample sample;
    sample.stamp_ns = i * kPeriod_ns;
    sample.angular_rate = TurnedImu().X_CI.rotation.conjugate() * rate_C;
    samples.push_back(sample);
  }
  return samples;
}

TEST(GyroTurn, OfAConstantRateIsItsProductWithTime) {
  GyroTurn gyro(TurnedImu());
  const Eigen::Vector3d rate_C(0.5, -1, 0.2);
  gyro.Add(Samples(rate_C, 0, 200));
  const auto turn = gyro.Between(101'300'000, 700'000'000);  // ends lie within samples' periods
  ASSERT_TRUE(turn);
  EXPECT_LT((*turn - 0.5987 * rate_C).norm(), 1e-12);
}

/// Doubles of such nanoseconds are 256 ns apart.
TEST(GyroTurn, TheClocksEpochMovesNoBit) {
  GyroTurn early(TurnedImu()), late(TurnedImu());
  std::vector<ImuSample> samples = Samples({0.5, -1, 0.2}, 0, 200);
  early.Add(samples);
  for (ImuSample& sample : samples) sample.stamp_ns += kClockStart_ns;
  late.Add(samples);
  const auto expected = early.Between(101'300'123, 700'000'457);
  const auto turn = late.Between(kClockStart_ns + 101'300'123, kClockStart_ns + 700'000'457);
  ASSERT_TRUE(expected && turn);
  EXPECT_EQ(*turn, *expected);
}

TEST(GyroTurn, ComposesRatesInTheirOrder) {
  GyroTurn gyro(TurnedImu());
  gyro.Add(Samples({2, 0, 0}, 0, 100));  // each covers half a period before and after its stamp
  gyro.Add(Samples({0, 3, 0}, 100, 200));
  const auto turn = gyro.Between(-2'500'000, 997'500'000);
  ASSERT_TRUE(turn);
  const Eigen::Quaterniond R_FT = ExpSo3({1, 0, 0}) * ExpSo3({0, 1.5, 0});
  EXPECT_LT((*turn - LogSo3(R_FT)).norm(), 1e-12);
}

TEST(GyroTurn, FillsSmallGapsAndRefusesLargeOnes) {
  GyroTurn gyro(TurnedImu());
  const Eigen::Vector3d rate_C(0, 0, 1);
  gyro.Add(Samples(rate_C, 0, 80));
  const auto turn = gyro.Between(0, 500'000'000);  // 80 % covered
  ASSERT_TRUE(turn);
  EXPECT_LT((*turn - 0.5 * rate_C).norm(), 1e-12);
  EXPECT_FALSE(gyro.Between(0, 600'000'000));  // 66 %
  gyro.DropBefore(40 * kPeriod_ns);
  EXPECT_FALSE(gyro.Between(0, 300'000'000));
  EXPECT_TRUE(gyro.Between(200'000'000, 300'000'000));
  EXPECT_TRUE(gyro.has_samples());
}

TEST(GyroTurn, LearnsABiasAsPreciselyAsItsMeasurementsAllow) {
  GyroTurn gyro(TurnedImu());
  const Eigen::Vector3d rate_C(0.1, 0.4, -0.2), bias_C(0.01, -0.015, 0.005);
  constexpr double kSigma_rad = 0.002, kTime_s = 0.5;
  constexpr int kMeasurements = 100;
  gyro.Add(Samples(rate_C + bias_C, 0, 400));
  for (int i = 0; i < kMeasurements; ++i) {
    const auto turn = gyro.Between(0, int64_t(kTime_s * 1e9));
    ASSERT_TRUE(turn);
    gyro.LearnBias(LogSo3(ExpSo3(kTime_s * rate_C).conjugate() * ExpSo3(*turn)), kTime_s, kSigma_rad);
  }
  // Measurements without noise. After n of them the prior's share of the bias is 0.04 / n; the rotation of 0.23 rad
  // during a measurement adds half of that to the error of the first one, which falls as 1 / n too.
  EXPECT_LT((gyro.bias() - bias_C).norm(), 0.01 * bias_C.norm());
  // The Kalman filter of a constant: information adds up.
  const double information = 1 / (0.02 * 0.02) + kMeasurements * std::pow(kTime_s / kSigma_rad, 2);
  EXPECT_NEAR(gyro.bias_sigma(), 1 / std::sqrt(information), 1e-12);
}

}  // namespace
}  // namespace gaitcam
