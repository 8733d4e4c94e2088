#include "algorithms/geometry/absolute_pose.h"

#include <gtest/gtest.h>

namespace gaitcam {
namespace {

constexpr double kFocal = 277;  // px; noise below is in pixels of such a camera

Pose SomePose() { return Pose(RotZ(0.4) * RotX(-1.2) * RotY(0.3), {0.5, -1.0, 0.35}); }

std::vector<PointSighting> Sightings(const Pose& X_WC, int count, int outliers, double noise_px, uint64_t seed) {
  RandomStream random(seed, "absolute_pose_test");
  std::vector<PointSighting> sightings;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d xy(random.Uniform(-0.57, 0.57), random.Uniform(-0.43, 0.43));
    const Eigen::Vector2d noise(random.Normal(), random.Normal());
    const bool outlier = i >= count - outliers;
    const Eigen::Vector2d seen(random.Uniform(-0.57, 0.57), random.Uniform(-0.43, 0.43));
    sightings.push_back({X_WC * (random.Uniform(1, 4) * xy.homogeneous()),
                         outlier ? seen : Eigen::Vector2d(xy + noise * noise_px / kFocal)});
  }
  return sightings;
}

RansacOptions Options(double threshold_px) {
  RansacOptions options;
  options.threshold = threshold_px / kFocal;
  return options;
}

TEST(ThreePoint, ThreeExactSightingsGiveTheTruePoseAmongOthers) {
  for (uint64_t seed = 0; seed < 30; ++seed) {
    double best = 1;
    for (const Pose& X_WC : SolveThreePoint(Sightings(SomePose(), 3, 0, 0, seed))) {
      best = std::min(
          best, (X_WC.translation - SomePose().translation).norm() + RotationAngle(X_WC.rotation, SomePose().rotation));
    }
    EXPECT_LT(best, 1e-5) << seed;  // a quartic costs digits; triangles that are nearly degenerate cost more
  }
}

TEST(AbsolutePose, OutliersAreFoundOut) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    RandomStream random(seed, "ransac");
    const auto found = EstimateAbsolutePose(Sightings(SomePose(), 100, 40, 0.5, seed), Options(2), random);
    // 60 points at 2.5 m with 0.5 px = 1.8 mrad: 0.25 mrad and 1 mm; errors of a draw reach three times that and more.
    EXPECT_LT((found.model.translation - SomePose().translation).norm(), 0.01) << seed;
    EXPECT_LT(RotationAngle(found.model.rotation, SomePose().rotation), 0.003) << seed;
    EXPECT_GE(found.inliers.size(), 55u);
    EXPECT_LE(found.inliers.size(), 64u);
  }
}

TEST(AbsolutePose, AGoodGuessIsKeptAndABadOneCostsNothing) {
  const auto sightings = Sightings(SomePose(), 50, 10, 0.2, 1);
  for (const Pose& guess : {SomePose(), Pose(RotX(2.0), {9, 9, 9})}) {
    RandomStream random(1, "ransac");
    const auto found = EstimateAbsolutePose(sightings, Options(2), random, guess);
    EXPECT_LT((found.model.translation - SomePose().translation).norm(), 0.01);
  }
}

TEST(AbsolutePose, RefinementFindsTheMinimumFromNearby) {
  const auto exact = Sightings(SomePose(), 30, 0, 0, 2);
  std::vector<int> all(30);
  for (int i = 0; i < 30; ++i) all[size_t(i)] = i;
  const Pose start = SomePose() * Pose(RotX(0.05) * RotY(-0.04), {0.05, 0.02, -0.1});
  const Pose refined = RefineAbsolutePose(exact, all, start, 1.0);
  EXPECT_LT((refined.translation - SomePose().translation).norm(), 1e-9);
  EXPECT_LT(RotationAngle(refined.rotation, SomePose().rotation), 1e-7);
}

TEST(AbsolutePose, WithoutEnoughToGoByThereIsNoPose) {
  RandomStream random(1, "ransac");
  EXPECT_TRUE(EstimateAbsolutePose({}, Options(2), random).inliers.empty());
  EXPECT_TRUE(EstimateAbsolutePose(Sightings(SomePose(), 3, 0, 0, 1), Options(2), random).inliers.empty());
  EXPECT_LT(EstimateAbsolutePose(Sightings(SomePose(), 60, 60, 0, 1), Options(2), random).inliers.size(), 10u);
  const std::vector<PointSighting> same(20, PointSighting{{0, 0, 2}, {0, 0}});
  EXPECT_TRUE(EstimateAbsolutePose(same, Options(2), random).model.Matrix().allFinite());
}

}  // namespace
}  // namespace gaitcam
