#include "algorithms/geometry/stereo_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "tests/algorithms/geometry/stereo_rigs.h"

namespace gaitcam {
namespace {

StereoRig NarrowRig() {
  StereoRig rig = ChapterRig();
  rig.X_LR.translation.x() = 0.12;
  return rig;
}

double Nees(const Pose& truth, const LikelyMotion& motion) {
  const Vector6d error = Minus(truth, motion.X_AB);
  return error.dot(motion.covariance.ldlt().solve(error)) / 6;
}

TEST(StereoMotion, ExactPixelsGiveTheMotionThroughDistortion) {
  RandomStream random(1, "exact");
  for (const StereoRig& rig : {ChapterRig(), DistortedRig()}) {
    const TwoPairs pairs(rig, 12, 1, 0.1, random, 1, 3);
    const LikelyMotion motion = RefineStereoMotion(rig, pairs.A, pairs.B, Pose());
    EXPECT_LT(Minus(motion.X_AB, pairs.X_AB).norm(), 1e-8);
    EXPECT_LT(motion.cost, 1e-10);
  }
}

TEST(StereoMotion, IsConsistentWhereWeightsOfMeasuredPointsAreNot) {
  // Depths of 3 to 5 m are known to 4 to 9 %, and 100 points average that to less than their common bias.
  RandomStream random(2, "consistent");
  const StereoRig rig = NarrowRig();
  constexpr int kTrials = 150, kPoints = 100;
  constexpr double kSigma_px = 1;
  double pixels = 0, points = 0, cost = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const TwoPairs noisy = TwoPairs(rig, kPoints, kSigma_px, 0.15, random, 3, 5).Noisy(kSigma_px, random);
    const LikelyMotion by_points =
        RefineRigidMotion(MatchesOf(noisy.Points(0, random, StereoCost::kMaximumLikelihood)), noisy.X_AB);
    const LikelyMotion by_pixels = RefineStereoMotion(rig, noisy.A, noisy.B, by_points.X_AB);
    points += Nees(noisy.X_AB, by_points) / kTrials;
    pixels += Nees(noisy.X_AB, by_pixels) / kTrials;
    cost += by_pixels.cost / kTrials;
  }
  EXPECT_NEAR(pixels, 1, 4 * std::sqrt(2.0 / 6 / kTrials));  // four standard errors of the mean
  EXPECT_GT(points, pixels + 0.25);
  EXPECT_NEAR(cost, 5 * kPoints - 6, 4 * std::sqrt(2 * (5.0 * kPoints - 6) / kTrials));
}

TEST(StereoMotion, TooFewPointsHaveNoCovariance) {
  RandomStream random(3, "few");
  const TwoPairs pairs(ChapterRig(), 2, 1, 0.1, random);
  EXPECT_TRUE(RefineStereoMotion(pairs.rig, pairs.A, pairs.B, pairs.X_AB).covariance.array().isNaN().all());
}

}  // namespace
}  // namespace gaitcam
