#include "algorithms/geometry/real_roots.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

// Coefficients, constant first, of the product of (x - r) and of (x^2 + 1 + k) for k below `complex_pairs`.
std::vector<double> WithRoots(const std::vector<double>& roots, int complex_pairs = 0) {
  std::vector<double> p = {1};
  const auto times = [&](const std::vector<double>& q) {
    std::vector<double> product(p.size() + q.size() - 1, 0.0);
    for (size_t i = 0; i < p.size(); ++i) {
      for (size_t j = 0; j < q.size(); ++j) product[i + j] += p[i] * q[j];
    }
    p = product;
  };
  for (const double r : roots) times({-r, 1});
  for (int k = 0; k < complex_pairs; ++k) times({1.0 + k, 0.3, 1});
  return p;
}

TEST(RealRoots, AreFoundWhereverTheyLie) {
  RandomStream random(1, "roots");
  for (int trial = 0; trial < 300; ++trial) {
    const int real = 2 * random.Index(3);
    std::vector<double> roots;
    for (int i = 0; i < real; ++i) roots.push_back(random.Uniform(-2, 2) * std::pow(10, random.Uniform(-1, 1)));
    std::sort(roots.begin(), roots.end());
    const auto found = RealRoots(WithRoots(roots, (10 - real) / 2));
    ASSERT_EQ(found.size(), roots.size()) << trial;
    // The condition of a root falls with the distance to its neighbours; random ones come as near as 1e-3.
    for (size_t i = 0; i < roots.size(); ++i) EXPECT_NEAR(found[i], roots[i], 1e-6 * (1 + std::abs(roots[i])));
  }
}

TEST(RealRoots, SimpleCases) {
  EXPECT_TRUE(RealRoots({}).empty());
  EXPECT_TRUE(RealRoots({5}).empty());
  EXPECT_TRUE(RealRoots({1, 0, 1}).empty());
  EXPECT_EQ(RealRoots({-2, 1}), std::vector<double>{2});
  EXPECT_EQ(RealRoots({0, 1, 0, 0}), std::vector<double>{0});  // leading zeros are dropped
  const auto pair = RealRoots({-1e6, 0, 1});
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_NEAR(pair[0], -1000, 1e-9);
  EXPECT_NEAR(pair[1], 1000, 1e-9);
  const auto doubled = RealRoots({0.25, -1, 1});  // (x - 0.5)^2
  ASSERT_LE(doubled.size(), 1u);
  for (const double root : doubled) EXPECT_NEAR(root, 0.5, 1e-6);
  EXPECT_TRUE(RealRoots({std::nan(""), 1, 1}).empty());
}

}  // namespace
}  // namespace gaitcam
