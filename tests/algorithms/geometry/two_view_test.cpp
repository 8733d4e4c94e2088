#include "algorithms/geometry/two_view.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <opencv2/core.hpp>

namespace gaitcam {
namespace {

constexpr double kFocal = 277;  // px; noise below is in pixels of such a camera

struct Problem {
  Pose X_AB;
  std::vector<PointPair> pairs;
  int outliers = 0;
};

// Points 1 to 4 m before camera A in a 60 degree field of view; the last `outliers` pairs are random.
Problem MakeProblem(const Pose& X_AB, int count, int outliers, double noise_px, uint64_t seed) {
  RandomStream random(seed, "two_view_test");
  Problem problem;
  problem.X_AB = X_AB;
  problem.outliers = outliers;
  const auto anywhere = [&] { return Eigen::Vector2d(random.Uniform(-0.57, 0.57), random.Uniform(-0.43, 0.43)); };
  const auto noise = [&]() -> Eigen::Vector2d {
    return Eigen::Vector2d(random.Normal(), random.Normal()) * noise_px / kFocal;
  };
  while (int(problem.pairs.size()) < count - outliers) {
    const Eigen::Vector2d a = anywhere();
    const Eigen::Vector3d p_B = X_AB.Inverse() * (random.Uniform(1, 4) * a.homogeneous());
    problem.pairs.push_back({a + noise(), p_B.hnormalized() + noise()});
  }
  for (int i = 0; i < outliers; ++i) problem.pairs.push_back({anywhere(), anywhere()});
  return problem;
}

Pose SomeMotion() { return Pose(RotY(0.08) * RotX(-0.05) * RotZ(0.1), {0.3, -0.05, 0.2}); }

RansacOptions Options(double threshold_px) {
  RansacOptions options;
  options.threshold = threshold_px / kFocal;
  return options;
}

double DirectionError(const Pose& estimate, const Pose& truth) {
  return std::acos(std::clamp(estimate.translation.normalized().dot(truth.translation.normalized()), -1.0, 1.0));
}

TEST(FivePoint, FiveExactPairsGiveTheTrueEssentialMatrixAmongOthers) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Problem problem = MakeProblem(SomeMotion(), 5, 0, 0, seed);
    double best = 1;
    const Pose X_BA = problem.X_AB.Inverse();
    Eigen::Matrix3d skew;
    const Eigen::Vector3d t = X_BA.translation.normalized();
    skew << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
    const Eigen::Matrix3d truth = (skew * X_BA.R()).normalized();
    for (const Eigen::Matrix3d& E : SolveFivePoint(problem.pairs)) {
      for (const PointPair& pair : problem.pairs) EXPECT_LT(SampsonError2(E, pair), 1e-12);
      best = std::min({best, (E.normalized() - truth).norm(), (E.normalized() + truth).norm()});
    }
    EXPECT_LT(best, 1e-6) << seed;  // a polynomial of degree 10 costs half of the digits
  }
}

TEST(TwoView, ExactPairsGiveTheExactPose) {
  const Problem problem = MakeProblem(SomeMotion(), 60, 0, 0, 1);
  RandomStream random(1, "ransac");
  const TwoView result = EstimateTwoView(problem.pairs, Options(1), random);
  EXPECT_EQ(result.inliers.size(), 60u);
  EXPECT_LT(RotationAngle(result.X_AB.rotation, problem.X_AB.rotation), 1e-7);
  EXPECT_LT(DirectionError(result.X_AB, problem.X_AB), 1e-6);
  EXPECT_NEAR(result.X_AB.translation.norm(), 1, 1e-12);
}

TEST(TwoView, OutliersAreFoundOutAndNoiseIsAveraged) {
  int good_kept = 0, good = 0, bad_kept = 0, bad = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Problem problem = MakeProblem(SomeMotion(), 150, 50, 0.5, seed);
    RandomStream random(seed, "ransac");
    const TwoView result = EstimateTwoView(problem.pairs, Options(2), random);
    EXPECT_LT(RotationAngle(result.X_AB.rotation, problem.X_AB.rotation), 0.01) << seed;
    EXPECT_LT(DirectionError(result.X_AB, problem.X_AB), 0.06) << seed;
    good += 100;
    bad += 50;
    for (const int i : result.inliers) ++(i < 100 ? good_kept : bad_kept);
  }
  EXPECT_GT(good_kept, 0.95 * good);
  EXPECT_LT(bad_kept, 0.1 * bad);  // a random pair lies within 2 px of its epipolar line by chance
}

TEST(TwoView, ItsOwnErrorBarIsHonest) {
  // Over many noise draws the direction's error must be what direction_sigma says along the worst of its two axes.
  double error2 = 0, sigma2 = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const Problem problem = MakeProblem(SomeMotion(), 120, 0, 0.3, seed);
    RandomStream random(seed, "ransac");
    const TwoView result = EstimateTwoView(problem.pairs, Options(2), random);
    const double error = DirectionError(result.X_AB, problem.X_AB);
    error2 += error * error / 60;
    sigma2 += result.direction_sigma * result.direction_sigma / 60;
  }
  // The error has two axes, of which sigma is the worse one: the ratio lies between 1 and 2, give or take the scatter
  // of 60 draws (20 %).
  EXPECT_GT(error2 / sigma2, 0.75);
  EXPECT_LT(error2 / sigma2, 2.5);
}

TEST(TwoView, ATurnOnTheSpotShowsNoParallax) {
  const Problem problem = MakeProblem(Pose(RotY(0.15), Eigen::Vector3d::Zero()), 100, 0, 0.3, 3);
  RandomStream random(3, "ransac");
  const TwoView result = EstimateTwoView(problem.pairs, Options(2), random);
  EXPECT_LT(RotationAngle(result.X_AB.rotation, problem.X_AB.rotation), 0.01);
  EXPECT_LT(result.parallax, 0.005);
  EXPECT_GT(result.direction_sigma, 0.1);
}

TEST(TwoView, WithoutEnoughToGoByThereIsNoPose) {
  RandomStream random(1, "ransac");
  EXPECT_TRUE(EstimateTwoView({}, Options(1), random).inliers.empty());
  EXPECT_TRUE(EstimateTwoView(MakeProblem(SomeMotion(), 7, 0, 0, 1).pairs, Options(1), random).inliers.empty());
  const std::vector<PointPair> same(50, {{0.1, 0.2}, {0.1, 0.2}});
  const TwoView result = EstimateTwoView(same, Options(1), random);
  EXPECT_TRUE(result.X_AB.Matrix().allFinite());
  EXPECT_TRUE(std::isfinite(result.parallax) && std::isfinite(result.direction_sigma));
}

TEST(TwoView, SameSeedSameBits) {
  const Problem problem = MakeProblem(SomeMotion(), 100, 30, 0.5, 1);
  RandomStream a(7, "ransac"), b(7, "ransac");
  const TwoView first = EstimateTwoView(problem.pairs, Options(2), a);
  cv::theRNG().state = 99;
  const TwoView second = EstimateTwoView(problem.pairs, Options(2), b);
  EXPECT_EQ(first.X_AB.translation, second.X_AB.translation);
  EXPECT_EQ(first.X_AB.rotation.coeffs(), second.X_AB.rotation.coeffs());
  EXPECT_EQ(first.inliers, second.inliers);
}

}  // namespace
}  // namespace gaitcam
