#include "algorithms/estimation/resampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gaitcam {
namespace {

TEST(NormalisedWeights, AreWhatTheLogarithmsSayUpToAConstant) {
  const std::vector<double> weights = NormalisedWeights({-1e6, -1e6 + std::log(3.0)});
  EXPECT_NEAR(weights[0], 0.25, 1e-9);
  EXPECT_NEAR(weights[1], 0.75, 1e-9);
  const double none = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(NormalisedWeights({none, none}), (std::vector<double>{0.5, 0.5}));
}

TEST(EffectiveSampleSize, IsTheirNumberIfEqualAndOneIfOneCarriesAll) {
  EXPECT_NEAR(EffectiveSampleSize(std::vector<double>(50, 0.02)), 50, 1e-9);
  EXPECT_NEAR(EffectiveSampleSize({0, 1, 0}), 1, 1e-12);
}

TEST(LowVarianceResample, DrawsEachSampleAsOftenAsItsWeightSaysButForARounding) {
  RandomStream random(3, "weights");
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> logs;
    for (int i = 0; i < 20; ++i) logs.push_back(random.Normal(0, 2));
    const std::vector<double> weights = NormalisedWeights(logs);
    constexpr int kDrawn = 100;
    const std::vector<int> indices = LowVarianceResample(weights, kDrawn, random);
    ASSERT_EQ(indices.size(), size_t(kDrawn));
    EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
    for (int i = 0; i < 20; ++i) {
      const double count = double(std::count(indices.begin(), indices.end(), i)),
                   expected = kDrawn * weights[size_t(i)];
      EXPECT_GE(count, std::floor(expected - 1e-9));
      EXPECT_LE(count, std::ceil(expected + 1e-9));
    }
  }
}

TEST(LowVarianceResample, HasNoFavourites) {
  // Mean count over many draws is the weight: 20,000 draws of variance below 1/4 have a mean within 4 * 0.5 / sqrt(n).
  const std::vector<double> weights{0.013, 0.487, 0.5};
  RandomStream random(5, "draws");
  double sum = 0;
  constexpr int kTrials = 20000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::vector<int> indices = LowVarianceResample(weights, 10, random);
    sum += double(std::count(indices.begin(), indices.end(), 0));
  }
  EXPECT_NEAR(sum / kTrials, 0.13, 4 * 0.5 / std::sqrt(kTrials));
}

}  // namespace
}  // namespace gaitcam
