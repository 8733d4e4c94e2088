#include "algorithms/geometry/eight_point.h"

#include <gtest/gtest.h>

#include "tests/algorithms/geometry/view_pairs.h"

namespace gaitcam {
namespace {

TEST(EightPoint, ExactPairsGiveTheExactMatrix) {
  for (const int count : {8, 9, 40}) {
    const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), count, 0, 0, 1);
    const auto E = SolveEightPoint(views.pairs);
    ASSERT_TRUE(E);
    EXPECT_LT(EssentialDistance(*E, TrueEssential(views.X_AB)), 1e-9) << count;
    EXPECT_NEAR(E->norm(), std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(E->determinant(), 0, 1e-12);
  }
}

TEST(EightPoint, MorePairsAverageNoise) {
  std::vector<double> few, many;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), 400, 0, 0.3, seed);
    const std::vector<PointPair> first(views.pairs.begin(), views.pairs.begin() + 20);
    few.push_back(EssentialDistance(*SolveEightPoint(first), TrueEssential(views.X_AB)));
    many.push_back(EssentialDistance(*SolveEightPoint(views.pairs), TrueEssential(views.X_AB)));
  }
  EXPECT_LT(UpperMedian(many), 0.4 * UpperMedian(few));  // sqrt(20 / 400) = 0.22 of the error
}

TEST(EightPoint, WhatIsNotDeterminedIsNotInvented) {
  EXPECT_FALSE(SolveEightPoint({}));
  EXPECT_FALSE(SolveEightPoint(MakeViewPairs(Scene::kDeep, SomeMotion(), 7, 0, 0, 1).pairs));
  const auto same = SolveEightPoint(std::vector<PointPair>(20, {{0.1, 0.2}, {0.1, 0.2}}));
  EXPECT_TRUE(!same || same->allFinite());
}

}  // namespace
}  // namespace gaitcam
