#include "results/scoring/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gaitcam {
namespace {

/// Differences of sizes 1 to n, the negative ones those of the sizes named.
std::vector<double> Sizes(int n, const std::vector<int>& negative) {
  std::vector<double> d;
  for (int i = 1; i <= n; ++i) d.push_back(std::count(negative.begin(), negative.end(), i) > 0 ? -i : i);
  return d;
}

/// A second way to the same number: every choice of signs is tried.
SignedRankTest ByTryingAllSigns(std::vector<double> d) {
  d.erase(std::remove(d.begin(), d.end(), 0.0), d.end());
  std::vector<double> ranks;
  for (const double x : d) {
    double below = 0, equal = 0;
    for (const double y : d) {
      below += std::abs(y) < std::abs(x);
      equal += std::abs(y) == std::abs(x);
    }
    ranks.push_back(below + (equal + 1) / 2);
  }
  const auto sum_of = [&](auto is_positive) {
    double sum = 0;
    for (size_t i = 0; i < d.size(); ++i) sum += is_positive(i) ? ranks[i] : 0;
    return sum;
  };
  const double observed = sum_of([&](size_t i) { return d[i] > 0; });
  const size_t all = size_t(1) << d.size();
  SignedRankTest test{int(d.size()), 0, 0, 0};
  for (size_t signs = 0; signs < all; ++signs) {
    const double sum = sum_of([&](size_t i) { return (signs >> i & 1) != 0; });
    test.p_greater += (sum >= observed) / double(all);
    test.p_less += (sum <= observed) / double(all);
  }
  test.p_two_sided = std::min(1.0, 2 * std::min(test.p_greater, test.p_less));
  return test;
}

TEST(Median, IsTheMiddleOrTheMeanOfTheTwoMiddleOnes) {
  EXPECT_EQ(MedianOf({3, 1, 2}), 2);
  EXPECT_EQ(MedianOf({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(MedianOf({7}), 7);
  EXPECT_TRUE(std::isnan(MedianOf({})));
}

TEST(Quantile, InterpolatesAsTypeSevenDoes) {
  // R: quantile(c(1, 2, 4, 8, 16), c(0.1, 0.25, 0.9), type = 7) is 1.4, 2, 12.8.
  const std::vector<double> values{16, 1, 8, 2, 4};
  EXPECT_NEAR(QuantileOf(values, 0.1), 1.4, 1e-12);
  EXPECT_EQ(QuantileOf(values, 0.25), 2);
  EXPECT_NEAR(QuantileOf(values, 0.9), 12.8, 1e-12);
  EXPECT_EQ(QuantileOf(values, 0), 1);
  EXPECT_EQ(QuantileOf(values, 1), 16);
  EXPECT_EQ(QuantileOf({5}, 0.95), 5);
  EXPECT_EQ(QuantileOf({2, 1}, 0.25), 1.25);
  EXPECT_TRUE(std::isnan(QuantileOf({}, 0.5)));
}

TEST(SignedRanks, AgreeWithThePublishedTableOfCriticalValues) {
  // Largest smaller rank sum that is significant at one-sided 0.05 and 0.01, by number of pairs: Wilcoxon & Wilcox
  // 1964.
  struct Row {
    int n, at_05, at_01;
  };
  for (const Row& row : {Row{7, 3, 0}, {8, 5, 1}, {10, 10, 5}, {15, 30, 19}, {20, 60, 43}, {25, 100, 76}}) {
    const auto p_of_sum = [&](int sum) {  // negative ranks that add up to `sum`, taken from the largest down
      std::vector<int> negative;
      for (int rank = row.n, left = sum; rank >= 1; --rank) {
        if (rank > left) continue;
        negative.push_back(rank);
        left -= rank;
      }
      return TestSignedRanks(Sizes(row.n, negative)).p_greater;
    };
    EXPECT_LE(p_of_sum(row.at_05), 0.05) << row.n;
    EXPECT_GT(p_of_sum(row.at_05 + 1), 0.05) << row.n;
    EXPECT_LE(p_of_sum(row.at_01), 0.01) << row.n;
    EXPECT_GT(p_of_sum(row.at_01 + 1), 0.01) << row.n;
  }
}

TEST(SignedRanks, EightPairsAllWorseAreTheLeastThatOnePercentCanTell) {
  EXPECT_EQ(TestSignedRanks(Sizes(7, {})).p_greater, 1.0 / 128);
  EXPECT_EQ(TestSignedRanks(Sizes(6, {})).p_greater, 1.0 / 64);
  const SignedRankTest eight = TestSignedRanks(Sizes(8, {}));
  EXPECT_EQ(eight.p_greater, 1.0 / 256);
  EXPECT_EQ(eight.p_two_sided, 1.0 / 128);
  EXPECT_EQ(eight.p_less, 1.0);
}

TEST(SignedRanks, AgreeWithTryingAllSignsWithTiesAndZeros) {
  RandomStream random(1, "signed_ranks");
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> d(size_t(1 + random.Index(11)));
    for (double& x : d) x = random.Index(9) - 4;  // few values, so many ties and zeros
    const SignedRankTest fast = TestSignedRanks(d), slow = ByTryingAllSigns(d);
    ASSERT_EQ(fast.pairs, slow.pairs);
    ASSERT_NEAR(fast.p_greater, slow.p_greater, 1e-12);  // sums of at most 2048 powers of two
    ASSERT_NEAR(fast.p_less, slow.p_less, 1e-12);
    ASSERT_NEAR(fast.p_two_sided, slow.p_two_sided, 1e-12);
  }
}

TEST(SignedRanks, MirroredDifferencesSwapTheSides) {
  const std::vector<double> d{0.3, -1.2, 2.5, 0.7, -0.1, 3.3};
  std::vector<double> mirrored;
  for (const double x : d) mirrored.push_back(-x);
  EXPECT_EQ(TestSignedRanks(d).p_greater, TestSignedRanks(mirrored).p_less);
  EXPECT_EQ(TestSignedRanks(d).p_two_sided, TestSignedRanks(mirrored).p_two_sided);
}

TEST(SignedRanks, NothingButZerosTellsNothing) {
  for (const std::vector<double>& d : {std::vector<double>{}, {0, 0, 0}}) {
    const SignedRankTest test = TestSignedRanks(d);
    EXPECT_EQ(test.pairs, 0);
    EXPECT_EQ(test.p_greater, 1);
    EXPECT_EQ(test.p_less, 1);
    EXPECT_EQ(test.p_two_sided, 1);
  }
}

/// The chance of a sum of positive ranks at least as large as that of differences of which no two are equally large.
double ExactGreater(std::vector<double> d) {
  std::sort(d.begin(), d.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  std::vector<double> chance{1};  // by sum
  size_t observed = 0;
  for (size_t rank = 1; rank <= d.size(); ++rank) {
    if (d[rank - 1] > 0) observed += rank;
    std::vector<double> next(chance.size() + rank, 0.0);
    for (size_t sum = 0; sum < chance.size(); ++sum) {
      next[sum] += chance[sum] / 2;
      next[sum + rank] += chance[sum] / 2;
    }
    chance = next;
  }
  return std::accumulate(chance.begin() + ptrdiff_t(observed), chance.end(), 0.0);
}

TEST(SignedRanks, TheNormalApproximationIsRightToTwoThousandths) {
  RandomStream random(3, "signed_ranks");
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> d;
    for (int i = 0; i < 60; ++i) d.push_back(random.Normal(0.2, 1));
    EXPECT_NEAR(TestSignedRanks(d).p_greater, ExactGreater(d), 0.002) << trial;  // ranks have shorter tails: 0.0014
  }
}

TEST(SignedRanks, ManyPairsGoOverSmoothlyIntoTheNormalApproximation) {
  RandomStream random(2, "signed_ranks");
  for (const int n : {51, 60}) {
    std::vector<double> d;
    for (int i = 0; i < n; ++i) d.push_back(random.Normal(0.2, 1));
    const SignedRankTest many = TestSignedRanks(d);
    const SignedRankTest fewer = TestSignedRanks({d.begin(), d.begin() + 50});
    EXPECT_EQ(many.pairs, n);
    EXPECT_GT(many.p_greater + many.p_less, 1.0);  // the observed sum is counted on both sides
    EXPECT_LT(many.p_greater + many.p_less, 1.01);
    // One more pair of 51 moves the standardized sum by at most about one rank in sqrt(n^3 / 12), 0.5 sigma.
    if (n == 51) {
      EXPECT_NEAR(many.p_greater, fewer.p_greater, 0.1);
    }
  }
}

TEST(SignedRanks, AreRightAboutPureChance) {
  // Of 2000 draws without any effect, at most as many as promised may look significant: 5 % and three sigma.
  RandomStream random(3, "signed_ranks");
  int alarms = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> d(10);
    for (double& x : d) x = random.Normal();
    alarms += TestSignedRanks(d).p_greater <= 0.05;
  }
  EXPECT_LT(alarms, 100 + 3 * std::sqrt(2000 * 0.05 * 0.95));
  EXPECT_GT(alarms, 40);  // the discrete test's true size at n = 10 is 0.042
}

TEST(HodgesLehmann, IsTheMedianOfWalshAverages) {
  // Averages of {1, 2, 6}: 1, 1.5, 3.5, 2, 4, 6; their median is 2.75.
  EXPECT_EQ(HodgesLehmann({6, 1, 2}), 2.75);
  EXPECT_EQ(HodgesLehmann({5}), 5);
  EXPECT_TRUE(std::isnan(HodgesLehmann({})));
}

TEST(HodgesLehmann, MovesWithAShiftAndShrugsAtOneOutlier) {
  std::vector<double> d{0.1, -0.2, 0.3, 0.0, -0.1, 0.2, 0.05, -0.05};
  const double before = HodgesLehmann(d);
  for (double& x : d) x += 3;
  EXPECT_NEAR(HodgesLehmann(d), before + 3, 1e-12);
  d[0] = 1e6;
  EXPECT_NEAR(HodgesLehmann(d), before + 3, 0.3);  // within the spread of the others
}

TEST(Bootstrap, IntervalHoldsTheTrueMedianAboutAsOftenAsItSays) {
  RandomStream data(4, "bootstrap_data"), random(4, "bootstrap");
  int held = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values(25);
    for (double& v : values) v = data.Normal(2, 1);
    const ConfidenceInterval interval = BootstrapMedian(values, 0.95, 400, random);
    ASSERT_LE(interval.low, interval.high);
    held += interval.low <= 2 && 2 <= interval.high;
  }
  // The percentile interval of a median of 25 normal values covers about 94 %; three sigma of 400 trials are 3.3 %.
  EXPECT_GT(held / double(kTrials), 0.90);
  EXPECT_LT(held / double(kTrials), 0.99);
}

TEST(Bootstrap, IsRepeatableAndExactWhereNothingVaries) {
  RandomStream one(5, "bootstrap"), other(5, "bootstrap");
  const std::vector<double> values{1, 5, 2, 8, 3, 9};
  const ConfidenceInterval a = BootstrapMedian(values, 0.95, 200, one), b = BootstrapMedian(values, 0.95, 200, other);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  const ConfidenceInterval same = BootstrapMedian({4, 4, 4}, 0.95, 100, one);
  EXPECT_EQ(same.low, 4);
  EXPECT_EQ(same.high, 4);
  EXPECT_TRUE(std::isnan(BootstrapMedian({}, 0.95, 100, one).low));
}

TEST(Holm, StepsDownAndKeepsTheOrderGiven) {
  // Four comparisons: 4 * 0.005, 3 * 0.01, max(0.03, 2 * 0.03), max(0.06, 1 * 0.04).
  const std::vector<double> adjusted = HolmAdjusted({0.01, 0.04, 0.03, 0.005});
  ASSERT_EQ(adjusted.size(), 4u);
  EXPECT_NEAR(adjusted[0], 0.03, 1e-12);
  EXPECT_NEAR(adjusted[1], 0.06, 1e-12);
  EXPECT_NEAR(adjusted[2], 0.06, 1e-12);
  EXPECT_NEAR(adjusted[3], 0.02, 1e-12);
}

TEST(Holm, OneComparisonStaysAndNoneExceedsOne) {
  EXPECT_EQ(HolmAdjusted({0.03}), std::vector<double>{0.03});
  EXPECT_EQ(HolmAdjusted({0.6, 0.9}), (std::vector<double>{1, 1}));
  EXPECT_TRUE(HolmAdjusted({}).empty());
}

}  // namespace
}  // namespace gaitcam
