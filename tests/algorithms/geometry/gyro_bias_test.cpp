#include "algorithms/geometry/gyro_bias.h"

#include <gtest/gtest.h>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

const Eigen::Vector3d kBias(0.004, -0.006, 0.002);

std::vector<ImuSample> Samples(int count, const Eigen::Vector3d& rate, double noise = 0) {
  RandomStream random(1, "gyro_bias_test");
  std::vector<ImuSample> samples(static_cast<size_t>(count));
  for (ImuSample& sample : samples)
    sample.angular_rate = rate + noise * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
  return samples;
}

TEST(GyroBias, IsTheMeanOfWhatAStandingRobotReads) {
  GyroBias gyro;
  EXPECT_EQ(gyro.bias().norm(), 0);
  gyro.Stand(Samples(2000, kBias, 0.002));
  EXPECT_EQ(gyro.bias().norm(), 0);  // not before it is asked to
  EXPECT_FALSE(gyro.learned());
  gyro.Learn();
  // Standard deviation of the mean 0.002 / sqrt(2000) = 4.5e-5 per axis; five of it.
  EXPECT_NEAR((gyro.bias() - kBias).norm(), 0, 2.3e-4);
  EXPECT_TRUE(gyro.learned());
}

TEST(GyroBias, AHeadThatTurnsTeachesNothing) {
  GyroBias gyro;
  gyro.Stand(Samples(400, kBias + Eigen::Vector3d(0, -0.5, 0)));
  gyro.Stand(Samples(300, kBias));  // the fewer of all
  gyro.Learn();
  EXPECT_EQ(gyro.bias().norm(), 0);
}

TEST(GyroBias, AShortRestTeachesNothing) {
  GyroBias gyro;
  gyro.Stand(Samples(50, kBias));
  gyro.Learn();
  EXPECT_EQ(gyro.bias().norm(), 0);
  EXPECT_FALSE(gyro.learned());
}

TEST(GyroBias, TheLastRestCounts) {
  GyroBias gyro;
  gyro.Stand(Samples(500, kBias));
  gyro.Learn();
  gyro.Stand(Samples(500, -kBias));
  gyro.Learn();
  EXPECT_NEAR((gyro.bias() + kBias).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace gaitcam
