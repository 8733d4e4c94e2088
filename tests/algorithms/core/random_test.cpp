#include "algorithms/core/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

TEST(RandomStream, SameSeedAndNameGiveTheSameBits) {
  RandomStream a(7, "camera"), b(7, "camera"), other_name(7, "imu"), other_seed(8, "camera");
  const uint64_t first = a.Bits();
  EXPECT_EQ(first, b.Bits());
  EXPECT_NE(first, other_name.Bits());
  EXPECT_NE(first, other_seed.Bits());
}

TEST(RandomStream, NormalHasZeroMeanUnitVarianceAndLightTails) {
  RandomStream random(1, "normal");
  const int n = 200000;
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.Normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  // Five standard errors of each sample moment.
  EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourth / n, 3, 5 * std::sqrt(96.0 / n));
}

TEST(RandomStream, IndexCoversItsRangeEvenly) {
  RandomStream random(1, "index");
  int counts[5] = {};
  for (int i = 0; i < 50000; ++i) ++counts[random.Index(5)];
  for (const int count : counts) EXPECT_NEAR(count, 10000, 5 * std::sqrt(8000));
}

}  // namespace
}  // namespace gaitcam
