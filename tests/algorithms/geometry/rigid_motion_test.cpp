#include "algorithms/geometry/rigid_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace gaitcam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const RigidMotionMethod kLeastSquares[] = {RigidMotionMethod::kHorn, RigidMotionMethod::kSvd,
                                           RigidMotionMethod::kMaximumLikelihood};

Vector3d Draw(RandomStream& random) { return {random.Normal(), random.Normal(), random.Normal()}; }

Pose DrawPose(RandomStream& random, double angle) { return {ExpSo3(angle * Draw(random).normalized()), Draw(random)}; }

std::vector<PointMatch> Cloud(int count, const Pose& X_AB, double sigma_m, RandomStream& random) {
  std::vector<PointMatch> matches;
  for (int i = 0; i < count; ++i) {
    const Vector3d p_B = Draw(random) + Vector3d(0, 0, 4);
    PointMatch match{X_AB * p_B + sigma_m * Draw(random), p_B + sigma_m * Draw(random)};
    if (sigma_m > 0) match.covariance_A = match.covariance_B = sigma_m * sigma_m * Matrix3d::Identity();
    matches.push_back(match);
  }
  return matches;
}

double SumOfSquares(const std::vector<PointMatch>& matches, const Pose& X_AB) {
  double sum = 0;
  for (const PointMatch& match : matches) sum += (match.p_A - X_AB * match.p_B).squaredNorm();
  return sum;
}

TEST(RigidMotion, ExactCloudsGiveTheMotionAtAnyAngle) {
  RandomStream random(1, "exact");
  for (int trial = 0; trial < 100; ++trial) {
    const Pose X_AB = DrawPose(random, trial % 10 == 0 ? 3.14159 : random.Uniform(0, 3));
    const auto matches = Cloud(3 + trial % 5, X_AB, 0, random);
    for (const RigidMotionMethod method : kLeastSquares) {
      const RigidMotion motion = FitRigidMotion(matches, method);
      ASSERT_TRUE(motion.ok());
      // A rotation is as well determined as its points lie off a line: three in a hundred may be near it.
      EXPECT_LT(Minus(motion.X_AB, X_AB).norm(), 1e-7);
    }
  }
}

TEST(RigidMotion, HornAndSvdFindTheSameMinimum) {
  RandomStream random(2, "minimum");
  for (int trial = 0; trial < 50; ++trial) {
    const auto matches = Cloud(4 + trial, DrawPose(random, 1), 0.1, random);
    const Pose horn = FitRigidMotion(matches, RigidMotionMethod::kHorn).X_AB;
    const Pose svd = FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB;
    EXPECT_LT(Minus(horn, svd).norm(), 1e-7);  // an eigenvector is exact to the root of what its value is
    const double sum = SumOfSquares(matches, svd);
    for (int axis = 0; axis < 6; ++axis) {
      for (const double step : {-1e-3, 1e-3})
        EXPECT_GT(SumOfSquares(matches, Plus(svd, step * Vector6d::Unit(axis))), sum);
    }
  }
}

TEST(RigidMotion, DirectionsAreExactForRotationsAndWrongWithTranslation) {
  RandomStream random(3, "directions");
  const Pose turn(ExpSo3({0.1, -0.2, 0.3}), {0, 0, 0});
  const RigidMotion turned = FitRigidMotion(Cloud(20, turn, 0, random), RigidMotionMethod::kHornDirections);
  EXPECT_LT(Minus(turned.X_AB, turn).norm(), 1e-7);
  const Pose step(turn.rotation, {0.3, 0, 0});
  const RigidMotion stepped = FitRigidMotion(Cloud(20, step, 0, random), RigidMotionMethod::kHornDirections);
  // Points at 4 m shift by 0.3 m: some 0.075 rad are taken for rotation.
  EXPECT_GT(RotationAngle(stepped.X_AB.rotation, step.rotation), 0.03);
}

TEST(RigidMotion, APlaneIsNoReflectionAndAMirrorIsSaid) {
  RandomStream random(4, "reflection");
  const Pose X_AB = DrawPose(random, 1);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<PointMatch> plane;
    for (int i = 0; i < 8; ++i) {
      const Vector3d p_B(random.Normal(), random.Normal(), 3);
      plane.push_back({X_AB * p_B + 1e-3 * Draw(random), p_B + 1e-3 * Draw(random)});
    }
    for (const RigidMotionMethod method : kLeastSquares) {
      const Pose X = FitRigidMotion(plane, method).X_AB;
      EXPECT_NEAR(X.R().determinant(), 1, 1e-12);
      EXPECT_LT(Minus(X, X_AB).norm(), 0.02);  // 1e-3 m over lever arms of some 0.3 m
    }
  }
  std::vector<PointMatch> mirrored = Cloud(10, X_AB, 0, random);
  EXPECT_FALSE(FitRigidMotion(mirrored, RigidMotionMethod::kSvd).reflected);
  for (PointMatch& match : mirrored) match.p_B.x() *= -1;
  EXPECT_TRUE(FitRigidMotion(mirrored, RigidMotionMethod::kSvd).reflected);
}

TEST(RigidMotion, DegenerateCloudsSayWhatTheyAre) {
  RandomStream random(5, "degenerate");
  const auto along = [](const Vector3d& d, const std::vector<double>& at) {
    std::vector<PointMatch> matches;
    for (const double s : at) matches.push_back({Vector3d(1, 2, 3) + s * d, Vector3d(0, 1, 5) + s * d});
    return matches;
  };
  auto nan = Cloud(5, Pose(), 0, random), huge = nan;
  nan[3].p_B.y() = std::numeric_limits<double>::quiet_NaN();
  huge[2].covariance_A(0, 0) = std::numeric_limits<double>::infinity();
  const Vector3d d = Vector3d(1, 2, -1).normalized();
  const std::pair<std::vector<PointMatch>, RigidMotionStatus> cases[] = {
      {{}, RigidMotionStatus::kTooFew},
      {Cloud(2, Pose(), 0, random), RigidMotionStatus::kTooFew},
      {along(d, {0, 0, 0, 0}), RigidMotionStatus::kPoint},
      {along(d, {0, 1, 2.5, 7}), RigidMotionStatus::kLine},
      {along(d, {0, 1e-3, 0.7e-3}), RigidMotionStatus::kLine},
      {nan, RigidMotionStatus::kNotFinite},
      {huge, RigidMotionStatus::kNotFinite}};
  for (const auto& [matches, status] : cases) {
    EXPECT_EQ(Degeneracy(matches), status);
    for (const RigidMotionMethod method : kLeastSquares) EXPECT_EQ(FitRigidMotion(matches, method).status, status);
    RandomStream draws(1, "ransac");
    const RobustRigidMotion robust = EstimateRigidMotion(matches, {}, draws);
    EXPECT_EQ(robust.motion.status, status);
    EXPECT_TRUE(robust.inliers.empty());
  }
}

/// Depth is known ten times worse than direction, and the worse the farther the point is, as stereo has it.
std::vector<PointMatch> StereoLikeCloud(int count, const Pose& X_AB, RandomStream& random) {
  std::vector<PointMatch> matches;
  const auto covariance = [](const Vector3d& p) {
    const Vector3d ray = p.normalized();
    const double across = 1e-3 * p.norm(), along = 5e-3 * p.squaredNorm();
    return Matrix3d(across * across * (Matrix3d::Identity() - ray * ray.transpose()) +
                    along * along * ray * ray.transpose());
  };
  const auto noisy = [&](const Vector3d& p, const Matrix3d& S) {
    return Vector3d(p + S.llt().matrixL() * Draw(random));
  };
  for (int i = 0; i < count; ++i) {
    const double z = random.Uniform(1, 6);
    const Vector3d p_B = z * Vector3d(random.Uniform(-0.5, 0.5), random.Uniform(-0.4, 0.4), 1), p_A = X_AB * p_B;
    const Matrix3d S_A = covariance(p_A), S_B = covariance(p_B);
    matches.push_back({noisy(p_A, S_A), noisy(p_B, S_B), S_A, S_B});
  }
  return matches;
}

TEST(RigidMotion, LikelihoodIsConsistentAndBeatsUnweightedFits) {
  RandomStream random(6, "likelihood");
  const Pose X_AB(ExpSo3({0.02, -0.05, 0.01}), {0.05, 0.01, 0.1});
  constexpr int kTrials = 400, kPoints = 40;
  double nees = 0, cost = 0, likely = 0, plain = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto matches = StereoLikeCloud(kPoints, X_AB, random);
    const LikelyMotion motion = RefineRigidMotion(matches, FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB);
    const Vector6d error = Minus(X_AB, motion.X_AB);
    nees += error.dot(motion.covariance.ldlt().solve(error)) / kTrials;
    cost += motion.cost / kTrials;
    likely += error.squaredNorm();
    plain += Minus(FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB, X_AB).squaredNorm();
  }
  // Means of chi-squares of n degrees over 400 trials: n +- 4 sqrt(2 n / 400).
  EXPECT_NEAR(nees, 6, 4 * std::sqrt(2 * 6.0 / kTrials));
  EXPECT_NEAR(cost, 3 * kPoints - 6, 4 * std::sqrt(2 * (3.0 * kPoints - 6) / kTrials));
  EXPECT_LT(likely, 0.5 * plain);
}

TEST(RigidMotion, RansacFindsTheInliersAmongMismatches) {
  for (const bool by_sigmas : {true, false}) {
    RandomStream random(7, "outliers"), draws(7, "ransac");
    const Pose X_AB(ExpSo3({0.1, 0.2, -0.1}), {0.2, 0.1, -0.3});
    auto matches = Cloud(60, X_AB, 0.01, random);
    for (int i = 0; i < 60; i += 3) matches[size_t(i)].p_B += 2 * Draw(random);
    RigidMotionOptions options;
    options.by_sigmas = by_sigmas;
    options.ransac.threshold = by_sigmas ? 4 : 0.05;
    const RobustRigidMotion robust = EstimateRigidMotion(matches, options, draws);
    ASSERT_TRUE(robust.motion.ok());
    EXPECT_LT(Minus(robust.motion.X_AB, X_AB).norm(), 0.02);
    EXPECT_GE(robust.inliers.size(), 38U);  // of 40, at four sigmas of three dimensions: 0.1 % each
    for (const int i : robust.inliers) EXPECT_NE(i % 3, 0);
  }
}

TEST(RigidMotion, WithoutConsensusThereIsNoMotion) {
  RandomStream random(8, "noise"), draws(8, "ransac");
  std::vector<PointMatch> matches;
  for (int i = 0; i < 30; ++i) {
    matches.push_back({Draw(random), Draw(random), 1e-6 * Matrix3d::Identity(), 1e-6 * Matrix3d::Identity()});
  }
  const RobustRigidMotion robust = EstimateRigidMotion(matches, {}, draws);
  EXPECT_EQ(robust.motion.status, RigidMotionStatus::kNoConsensus);
  EXPECT_TRUE(robust.inliers.empty());
}

TEST(RigidMotion, SameStreamSameResult) {
  RandomStream random(9, "same");
  const auto matches = Cloud(40, DrawPose(random, 0.3), 0.02, random);
  RandomStream a(1, "ransac"), b(1, "ransac");
  const RobustRigidMotion one = EstimateRigidMotion(matches, {}, a), two = EstimateRigidMotion(matches, {}, b);
  EXPECT_EQ(one.inliers, two.inliers);
  EXPECT_EQ(one.motion.X_AB.translation, two.motion.X_AB.translation);
}

}  // namespace
}  // namespace gaitcam
