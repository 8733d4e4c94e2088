#include "algorithms/odometry/landmark_drift.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

Matrix6d RandomCovariance(RandomStream& random) {
  Matrix6d A;
  for (double& x : A.reshaped()) x = random.Normal(0, 0.1);
  return A * A.transpose();
}

Pose RandomPose(RandomStream& random) {
  Vector6d tau;
  for (double& x : tau) x = random.Normal(0, 0.3);
  return Plus(Pose(), tau);
}

double SmallestEigenvalue(const Matrix6d& A) { return Eigen::SelfAdjointEigenSolver<Matrix6d>(A).eigenvalues()[0]; }

TEST(PositivePart, KeepsWhatIsPositiveAndNothingElse) {
  RandomStream random(1, "test");
  const Matrix6d A = RandomCovariance(random), B = RandomCovariance(random), whole = A + B;
  EXPECT_LT((PositivePart(A, whole) - A).norm(), 1e-12);
  EXPECT_LT(PositivePart(-A, whole).norm(), 1e-12);
  const Matrix6d part = PositivePart(A - B, whole);
  EXPECT_GE(SmallestEigenvalue(part), -1e-12);
  EXPECT_GE(SmallestEigenvalue(part - (A - B)), -1e-12) << "what was taken away is negative";
}

TEST(GrowingCovariance, NeverShrinksAndIsNoLessThanAnyOfThem) {
  RandomStream random(2, "test");
  GrowingCovariance growing;
  Pose last;
  Matrix6d before = Matrix6d::Zero();
  for (int i = 0; i < 20; ++i) {
    const Pose X_WC = RandomPose(random);
    const Matrix6d own = RandomCovariance(random);
    growing.Add(X_WC, own);
    const double size = 1e-9 * growing.covariance().norm();
    EXPECT_GE(SmallestEigenvalue(growing.covariance() - own), -size);
    EXPECT_GE(SmallestEigenvalue(growing.covariance() - CarryCovariance(before, last.Inverse() * X_WC)), -size);
    last = X_WC;
    before = growing.covariance();
  }
}

TEST(GrowingCovariance, AHeadThatSwaysBackKeepsWhatItHad) {
  RandomStream random(3, "test");
  const Matrix6d away = RandomCovariance(random);
  GrowingCovariance growing;
  for (const double share : {0.5, 1.0, 0.25, 1.0, 1e-6}) growing.Add({}, share * away);
  EXPECT_LT((growing.covariance() - away).norm(), 1e-9 * away.norm());
  EXPECT_NEAR(growing.ShareOf(away), 1, 1e-9);
  EXPECT_NEAR(growing.ShareOf(4 * away), 0.25, 1e-9);
  EXPECT_EQ(growing.ShareOf(0.5 * away), 1);
}

// One landmark a metre off, whose depth is wrong by a standard deviation of 1 cm: x of the pose moves with x of it.
struct OneLandmark {
  std::vector<StereoLandmark> landmarks{{{0, 0, 1}, Eigen::Vector3d(1e-6, 1e-6, 1e-4).asDiagonal(), {}, {}, {}}};
  static LandmarkGains Seen(double by_depth) {
    Eigen::Matrix<double, 6, 3> gain = Eigen::Matrix<double, 6, 3>::Zero();
    gain(0, 2) = by_depth;
    return {{}, {{0, gain}}};
  }
};

TEST(DifferenceOfLandmarks, IsThatOfTheTwoPosesErrors) {
  const OneLandmark one;
  EXPECT_EQ(DifferenceOfLandmarks(one.Seen(0.5), one.Seen(0.5), one.landmarks).norm(), 0) << "all cancels";
  EXPECT_NEAR(DifferenceOfLandmarks(one.Seen(0.5), one.Seen(0.8), one.landmarks)(0, 0), 0.09e-4, 1e-12);
  EXPECT_NEAR(DifferenceOfLandmarks({}, one.Seen(0.8), one.landmarks)(0, 0), 0.64e-4, 1e-12) << "seen by one alone";
}

}  // namespace
}  // namespace gaitcam
