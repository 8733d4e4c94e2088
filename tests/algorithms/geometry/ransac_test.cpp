#include "algorithms/geometry/ransac.h"

#include <gtest/gtest.h>

#include <set>

namespace gaitcam {
namespace {

TEST(Ransac, SamplesHaveNoIndexTwiceAndReachAll) {
  RandomStream random(1, "ransac_test");
  std::set<int> seen;
  for (int i = 0; i < 200; ++i) {
    const auto sample = internal::DrawSample(6, 5, random);
    EXPECT_EQ(std::set<int>(sample.begin(), sample.end()).size(), 5u);
    seen.insert(sample.begin(), sample.end());
  }
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2, 3, 4, 5}));
}

TEST(Ransac, TheNumberOfSamplesFollowsTheFormula) {
  // Half of the data good, 5 per sample: 1 in 32 samples is clean; 145 miss all with 1 %.
  EXPECT_EQ(internal::SamplesNeeded(0.5, 5, 0.99, 10000), 146);
  EXPECT_EQ(internal::SamplesNeeded(0.5, 5, 0.99, 100), 100);
  EXPECT_EQ(internal::SamplesNeeded(0, 5, 0.99, 100), 100);
  EXPECT_EQ(internal::SamplesNeeded(1, 5, 0.99, 100), 1);
}

TEST(Ransac, TheConstantMostDataAgreeOnIsFound) {
  // The model is a number, one datum makes one.
  std::vector<double> data;
  for (int i = 0; i < 30; ++i) data.push_back(i % 3 == 0 ? 100.0 * i : 5 + 0.01 * i);
  RansacOptions options;
  options.threshold = 1;
  RandomStream random(1, "ransac_test");
  const auto found = Ransac<double>(
      30, 1, options, random, [&](const std::vector<int>& s) { return std::vector<double>{data[size_t(s[0])]}; },
      [&](double model, int i) { return (data[size_t(i)] - model) * (data[size_t(i)] - model); });
  EXPECT_EQ(found.inliers.size(), 20u);
  EXPECT_NEAR(found.model, 5.15, 0.15);
  // Ten outliers cost the full threshold each, the inliers less than 0.3 squared.
  EXPECT_GT(found.score, 10);
  EXPECT_LT(found.score, 12);
}

TEST(Ransac, FewerDataThanASampleMakeNoModel) {
  RandomStream random(1, "ransac_test");
  const auto found = Ransac<double>(
      2, 3, RansacOptions(), random, [](const std::vector<int>&) { return std::vector<double>{0}; },
      [](double, int) { return 0.0; });
  EXPECT_TRUE(found.inliers.empty());
}

}  // namespace
}  // namespace gaitcam
