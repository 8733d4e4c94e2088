#include "scenarios/code/experiments/threshold_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gaitcam {
namespace {

TEST(ThresholdSearch, EnclosesTheThresholdToTheLastHalving) {
  constexpr double kLargest = 80, kStep = kLargest / 32;
  for (double truth = 0.3; truth < kLargest; truth += 0.7) {
    int tried = 0;
    const Threshold found = FindThreshold(kLargest, 5, [&](double level) { return ++tried, level >= truth; });
    ASSERT_TRUE(found.fails_at);
    EXPECT_GE(*found.fails_at, truth);
    EXPECT_LT(found.holds_at, truth);
    EXPECT_DOUBLE_EQ(*found.fails_at - found.holds_at, kStep);  // powers of two: exact
    EXPECT_TRUE(found.is_monotone);
    EXPECT_LE(tried, 7);
  }
}

TEST(ThresholdSearch, SaysThatNothingFailsOrThatTheSmallestLevelDoes) {
  const Threshold never = FindThreshold(8, 3, [](double) { return false; });
  EXPECT_FALSE(never.fails_at);
  EXPECT_EQ(never.holds_at, 8);
  EXPECT_TRUE(never.is_monotone);
  const Threshold always = FindThreshold(8, 3, [](double) { return true; });
  EXPECT_EQ(always.fails_at, 1);
  EXPECT_EQ(always.holds_at, 0);
  EXPECT_TRUE(always.is_monotone);
}

TEST(ThresholdSearch, NoticesALevelAboveTheThresholdThatHolds) {
  // Fails from 2 on, but for a gap round 5, the middle between 2 and the largest.
  const Threshold gap = FindThreshold(8, 3, [](double x) { return x >= 2 && std::abs(x - 5) > 0.5; });
  EXPECT_EQ(gap.fails_at, 2);
  EXPECT_FALSE(gap.is_monotone);
  // The largest holds, half of it does not: the first threshold is what is looked for.
  const Threshold returns = FindThreshold(8, 3, [](double x) { return x >= 3 && x < 6; });
  EXPECT_EQ(returns.fails_at, 3);
  EXPECT_EQ(returns.holds_at, 2);
  EXPECT_FALSE(returns.is_monotone);
}

TEST(ThresholdSearch, TriesNoLevelTwice) {
  for (double truth = 0.1; truth < 16; truth += 0.5) {
    std::vector<double> tried;
    FindThreshold(16, 4, [&](double level) {
      for (const double other : tried) EXPECT_NE(level, other) << truth;
      tried.push_back(level);
      return level >= truth;
    });
  }
}

}  // namespace
}  // namespace gaitcam
