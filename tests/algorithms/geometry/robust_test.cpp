#include "algorithms/geometry/robust.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace gaitcam {
namespace {

struct Line {
  double slope = 0, offset = 0;
};

// y = 2 x + 1 with noise of 0.01, of which the last `outliers` are anywhere.
std::vector<Eigen::Vector2d> LinePoints(int n, int outliers, uint64_t seed) {
  RandomStream random(seed, "line");
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < n; ++i) {
    const double x = random.Uniform(-1, 1);
    points.emplace_back(x, i < n - outliers ? 2 * x + 1 + random.Normal(0, 0.01) : random.Uniform(-3, 5));
  }
  return points;
}

RansacResult<Line> FitLine(const std::vector<Eigen::Vector2d>& points, RobustEstimator estimator, uint64_t seed) {
  RansacOptions options;
  options.threshold = 0.03;
  options.estimator = estimator;
  options.outlier_span = 8;
  RandomStream random(seed, "fit");
  const auto solve = [&](const std::vector<int>& two) {
    const Eigen::Vector2d p = points[size_t(two[0])], q = points[size_t(two[1])];
    const double slope = (q.y() - p.y()) / (q.x() - p.x());
    return std::vector<Line>{{slope, p.y() - slope * p.x()}};
  };
  const auto residual2 = [&](const Line& line, int i) {
    const double e = points[size_t(i)].y() - line.slope * points[size_t(i)].x() - line.offset;
    return e * e;
  };
  return EstimateRobustly<Line>(int(points.size()), 2, options, random, solve, residual2);
}

class EveryEstimator : public testing::TestWithParam<RobustEstimator> {};

TEST_P(EveryEstimator, FindsTheLineAmongOutliers) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const auto found = FitLine(LinePoints(300, 150, seed), GetParam(), seed);
    EXPECT_NEAR(found.model.slope, 2, 0.05);
    EXPECT_NEAR(found.model.offset, 1, 0.03);
    EXPECT_GT(found.inliers.size(), 120u);
    EXPECT_LT(found.inliers.size(), 170u);
  }
}

TEST_P(EveryEstimator, SameSeedSameAnswer) {
  const auto points = LinePoints(100, 50, 1);
  const auto a = FitLine(points, GetParam(), 5), b = FitLine(points, GetParam(), 5);
  EXPECT_EQ(a.model.slope, b.model.slope);
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.score, b.score);
}

TEST_P(EveryEstimator, TooFewDataAreNoModel) {
  EXPECT_TRUE(FitLine({}, GetParam(), 1).inliers.empty());
  EXPECT_TRUE(FitLine({{0, 1}}, GetParam(), 1).inliers.empty());
}

INSTANTIATE_TEST_SUITE_P(, EveryEstimator,
                         testing::Values(RobustEstimator::kRansac, RobustEstimator::kMlesac,
                                         RobustEstimator::kPreemptive),
                         [](const auto& info) { return std::string(ToWord(info.param)); });

TEST(Mixture, ExpectationMaximisationFindsTheShareOfInliers) {
  RandomStream random(1, "mixture");
  for (const double share : {0.2, 0.5, 0.9}) {
    std::vector<double> residuals2, densities(4000);
    for (int i = 0; i < 4000; ++i) {
      const double e = random.Uniform() < share ? random.Normal(0, 0.01) : random.Uniform(-0.5, 0.5);
      residuals2.push_back(e * e);
    }
    const auto fit = internal::FitMixture(residuals2, 0.01, 1, densities);
    EXPECT_NEAR(fit.gamma, share, 0.03);  // five steps of EM, and sqrt(0.25 / 4000) = 0.008 of chance
    const auto wrong = internal::FitMixture(residuals2, 0.03, 1, densities);
    EXPECT_LT(fit.minus_log_likelihood, wrong.minus_log_likelihood);
  }
}

}  // namespace
}  // namespace gaitcam
