#include "algorithms/geometry/homography.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/algorithms/geometry/view_pairs.h"

namespace gaitcam {
namespace {

std::vector<int> All(const ViewPairs& views) {
  std::vector<int> all(views.pairs.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(Homography, MapsAPlaneExactly) {
  const ViewPairs views = MakeViewPairs(Scene::kPlane, SomeMotion(), 30, 0, 0, 1);
  const auto H = EstimateHomography(views.pairs, All(views));
  ASSERT_TRUE(H);
  for (const PointPair& pair : views.pairs) EXPECT_LT(TransferError2(*H, pair), 1e-18);
  EXPECT_FALSE(EstimateHomography(views.pairs, {0, 1, 2}));
}

TEST(Homography, AllowsTheTrueMotionAmongOthers) {
  for (uint64_t seed = 0; seed < 30; ++seed) {
    const ViewPairs views = MakeViewPairs(Scene::kPlane, RandomMotion(seed), 30, 0, 0, seed);
    const auto H = EstimateHomography(views.pairs, All(views));
    ASSERT_TRUE(H);
    const Pose X_BA = views.X_AB.Inverse();
    double best = 1;
    for (const PlaneMotion& motion : DecomposeHomography(*H)) {
      EXPECT_LT((motion.R + motion.t * motion.normal.transpose() - *H).norm(), 1e-9);
      best = std::min(best, (motion.R - X_BA.R()).norm() + (motion.t - X_BA.translation / 2).norm());  // d = 2 m
    }
    EXPECT_LT(best, 1e-6) << seed;
  }
}

TEST(Homography, OfATurnIsTheTurn) {
  const ViewPairs views = MakeViewPairs(Scene::kDeep, Pose(RotY(0.2), Eigen::Vector3d::Zero()), 30, 0, 0, 1);
  const auto H = EstimateHomography(views.pairs, All(views));
  ASSERT_TRUE(H);
  EXPECT_LT((*H - RotY(-0.2)).norm(), 1e-9);
  for (const PlaneMotion& motion : DecomposeHomography(*H)) {
    EXPECT_LT((motion.R - RotY(-0.2)).norm(), 1e-6);
    EXPECT_LT(motion.t.norm(), 1e-6);
  }
}

}  // namespace
}  // namespace gaitcam
