#include "algorithms/places/loop_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace gaitcam {
namespace {

std::vector<bool> Any(size_t nodes) { return std::vector<bool>(nodes, false); }

LoopFilterOptions Thesis() {
  LoopFilterOptions options;
  options.likelihood = LoopLikelihood::kSimilarity;
  options.transition = LoopTransition::kUniform;
  options.threshold = 2;
  return options;
}

TEST(LoopFilter, IsTheHandComputedPosteriorOfEquation46) {
  LoopFilter filter(Thesis());
  for (int step = 0; step < 2; ++step) {  // a uniform transition forgets what was
    const LoopFilter::Belief belief = filter.Update({1, 5, 7}, {false, false, true}, {});
    EXPECT_EQ(belief.likelihood, (std::vector<double>{2, 1, 5, 0}));
    EXPECT_NEAR(belief.posterior[0], 2.0 / 8, 1e-12);
    EXPECT_NEAR(belief.posterior[1], 1.0 / 8, 1e-12);
    EXPECT_NEAR(belief.posterior[2], 5.0 / 8, 1e-12);
    EXPECT_EQ(belief.posterior[3], 0);
    EXPECT_EQ(belief.best, 1);
  }
}

TEST(LoopFilter, BelievesInNoLoopBelowTheThreshold) {
  for (const auto likelihood : {LoopLikelihood::kSimilarity, LoopLikelihood::kBits}) {
    LoopFilterOptions options = Thesis();
    options.likelihood = likelihood;
    EXPECT_EQ(LoopFilter(options).Update({1.5, 1.99, 1.2}, Any(3), {}).best, -1);
    EXPECT_EQ(LoopFilter(options).Update({1.5, 2.01, 1.2}, Any(3), {}).best, 1);
    EXPECT_EQ(LoopFilter(options).Update({}, {}, {}).best, -1);
  }
}

TEST(LoopFilter, WeighsBitsByTheirBinomialLikelihoodRatio) {
  LoopFilterOptions options = Thesis();
  options.likelihood = LoopLikelihood::kBits;
  options.sharpness = 40;
  // Shares of bits that differ: 1/(2 sim) = 0.2 and 0.3; the threshold's is 0.25.
  const LoopFilter::Belief belief = LoopFilter(options).Update({2.5, 0.5 / 0.3}, Any(2), {});
  EXPECT_NEAR(belief.likelihood[0], 1, 1e-12);
  EXPECT_NEAR(belief.likelihood[1], std::exp(40 * 0.05), 1e-9);
  EXPECT_NEAR(belief.likelihood[2], std::exp(-40 * 0.05), 1e-9);
}

TEST(LoopFilter, KeepsProbabilityNearItsNeighboursAndLetsAShareGoAnywhere) {
  LoopFilterOptions options = Thesis();
  options.transition = LoopTransition::kNeighbours;
  options.teleport = 0.2;
  LoopFilter filter(options);
  const std::vector<PlaceLink> links = {{0, 1, false, 0}, {1, 2, false, 0}};
  const std::vector<double> first = filter.Update({1, 6, 1}, Any(3), links).posterior;  // 2, 1, 6, 1 of 10
  EXPECT_NEAR(first[2], 0.6, 1e-12);
  // By hand: "no loop" stays; node 0 shares with 1, node 1 with 0 and 2, node 2 with 1; 0.2 go anywhere.
  const double predicted[] = {0.05 + 0.8 * 0.2, 0.05 + 0.8 * (0.1 / 2 + 0.6 / 3),
                              0.05 + 0.8 * (0.1 / 2 + 0.6 / 3 + 0.1 / 2), 0.05 + 0.8 * (0.6 / 3 + 0.1 / 2)};
  EXPECT_NEAR(std::accumulate(std::begin(predicted), std::end(predicted), 0.0), 1, 1e-12);
  const std::vector<double> second = filter.Update({2, 2, 2}, Any(3), links).posterior;  // says nothing
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(second[i], predicted[i], 1e-12);
  filter.Reset();
  EXPECT_NEAR(filter.Update({2, 2, 2}, Any(3), links).posterior[2], 0.25, 1e-12);
}

TEST(LoopFilter, TakesNewNodesIn) {
  LoopFilterOptions options = Thesis();
  options.transition = LoopTransition::kNeighbours;
  LoopFilter filter(options);
  filter.Update({4}, Any(1), {});
  const LoopFilter::Belief belief = filter.Update({1, 400}, {true, false}, {{0, 1, false, 0}});
  ASSERT_EQ(belief.posterior.size(), 3u);
  EXPECT_EQ(belief.best, 1);
}

TEST(LoopFilter, OptionsAreChecked) {
  LoopFilterOptions options;
  options.threshold = 0.5;
  EXPECT_THROW(LoopFilter{options}, BadOption);
  options = {};
  options.transition = static_cast<LoopTransition>(2);
  EXPECT_THROW(LoopFilter{options}, BadOption);
}

}  // namespace
}  // namespace gaitcam
