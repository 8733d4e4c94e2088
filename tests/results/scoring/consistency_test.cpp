#include "results/scoring/consistency.h"

#include <gtest/gtest.h>

#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

/// An odometry whose every step has errors of the given standard deviations, and says so; `claim` times as large.
std::vector<PosePair> Odometry(uint64_t seed, double claim) {
  const Trajectory truth = SwayingCircle(400, 1, 3);
  constexpr double kRho = 0.002, kPhi = 0.001;
  Vector6d sigma;
  sigma << kRho, kRho, kRho, kPhi, kPhi, kPhi;
  const Matrix6d step_covariance = (claim * claim * sigma.array().square()).matrix().asDiagonal();
  RandomStream random(seed, "nees");
  std::vector<PosePair> pairs;
  Pose estimate = truth.front().pose;
  Matrix6d covariance = 1e-14 * Matrix6d::Identity();
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i > 0) {
      Vector6d error;
      for (int k = 0; k < 6; ++k) error[k] = sigma[k] * random.Normal();
      const Pose step = truth[i - 1].pose.Inverse() * truth[i].pose * ExpSe3(error);
      const Matrix6d carry = Adjoint(step.Inverse());
      estimate = estimate * step;
      covariance = Matrix6d(carry * covariance * carry.transpose()) + step_covariance;
    }
    pairs.push_back({truth[i].stamp_ns, truth[i].pose, estimate, covariance});
  }
  return pairs;
}

double MeanOverWalks(double claim, bool relative) {
  double sum = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const std::vector<PosePair> pairs = Odometry(seed, claim);
    sum += MeanNees(relative ? RelativeNees(pairs, 1) : AbsoluteNees(pairs));
  }
  return sum / 100;
}

// 100 walks of about 12 independent seconds: the mean of 7200 squared normals has a standard error of 1.7 %; absolute
// errors of one walk hang together, so that each walk gives some two of them: 4 %.
TEST(Consistency, OfAnHonestOdometryIsOne) {
  EXPECT_NEAR(MeanOverWalks(1, true), 1, 0.06);
  EXPECT_NEAR(MeanOverWalks(1, false), 1, 0.15);
}

TEST(Consistency, ChiSquareBandsAreThoseOfTables) {
  for (const auto& [degrees, low, high] : {std::tuple{30, 16.791, 46.979}, {100, 74.222, 129.561}}) {
    const ChiSquareInterval band = ChiSquareBand(degrees);
    EXPECT_NEAR(band.low, low, 1e-3 * low);
    EXPECT_NEAR(band.high, high, 1e-3 * high);
    EXPECT_TRUE(band.Contains(degrees));
    EXPECT_FALSE(band.Contains(high + 1));
    EXPECT_FALSE(band.Contains(low - 1));
  }
  EXPECT_NEAR(ChiSquareBand(100, 1.644854).high, 124.342, 0.1);  // 95 % from below
}

TEST(Consistency, GoesWithTheSquareOfWhatIsClaimed) {
  const std::vector<PosePair> honest = Odometry(1, 1), bold = Odometry(1, 0.5);
  EXPECT_NEAR(MeanNees(AbsoluteNees(bold)) / MeanNees(AbsoluteNees(honest)), 4, 1e-3);
  EXPECT_NEAR(MeanNees(RelativeNees(bold, 1)) / MeanNees(RelativeNees(honest, 1)), 4, 1e-3);
}

TEST(Consistency, NineteenOfTwentyLieInTheBand) {
  double share = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) share += ShareInBand(RelativeNees(Odometry(seed, 1), 1)) / 100;
  EXPECT_NEAR(share, 0.95, 0.02);  // 1200 independent seconds: 0.6 % standard error
}

// The estimator's world and the truth's are strangers.
TEST(Consistency, DoesNotDependOnWhereTheWorldLies) {
  std::vector<PosePair> pairs = Odometry(1, 1);
  const double before = MeanNees(AbsoluteNees(pairs)), relative = MeanNees(RelativeNees(pairs, 1));
  const Pose X(Eigen::Matrix3d(RotZ(1)), {3, 4, 5});
  for (PosePair& pair : pairs) pair.estimate = X * pair.estimate;
  EXPECT_NEAR(MeanNees(AbsoluteNees(pairs)), before, 1e-6 * before);
  EXPECT_NEAR(MeanNees(RelativeNees(pairs, 1)), relative, 1e-6 * relative);
}

// Poses that an odometry's steps carry, and each with an error of its own on top that the next pose does not have.
std::vector<PosePair> WithErrorsOfTheirOwn(uint64_t seed) {
  std::vector<PosePair> pairs = Odometry(seed, 1);
  RandomStream random(seed, "own");
  constexpr double kSigma = 0.003;
  for (PosePair& pair : pairs) {
    Vector6d error;
    for (double& value : error) value = kSigma * random.Normal();
    pair.own_covariance = kSigma * kSigma * Matrix6d::Identity();
    pair.estimate = pair.estimate * ExpSe3(error);
    pair.covariance = CarryCovariance(*pair.covariance, ExpSe3(error)) + *pair.own_covariance;
  }
  return pairs;
}

// As above: standard errors of 1.7 %, and of 0.7 % over the frames.
TEST(Consistency, WhatIsAPosesOwnDoesNotCancel) {
  double second = 0, frame = 0, blind = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    std::vector<PosePair> pairs = WithErrorsOfTheirOwn(seed);
    second += MeanNees(RelativeNees(pairs, 1)) / 100;
    frame += MeanNees(FrameNees(pairs)) / 100;
    for (PosePair& pair : pairs) pair.own_covariance.reset();
    blind += MeanNees(FrameNees(pairs)) / 100;
  }
  EXPECT_NEAR(second, 1, 0.06);
  EXPECT_NEAR(frame, 1, 0.03);
  EXPECT_GT(blind, 1.5) << "as if all were shared";
}

/// Every walk through the same motions has one error of its own, which is the same in all its frames: the camera that
/// is told is the true one, turned.
std::vector<PosePair> WithACommonError(uint64_t seed) {
  std::vector<PosePair> pairs = Odometry(seed, 1);
  RandomStream random(seed, "common");
  constexpr double kSigma = 0.1;
  Vector6d one = Vector6d::Zero();
  one[4] = kSigma;
  const Pose turned = ExpSe3(random.Normal() * one);
  const Pose first = pairs.front().estimate;
  for (PosePair& pair : pairs) {
    const Pose X = first.Inverse() * pair.estimate;
    pair.common_errors = Adjoint(X.Inverse()) * one - one;
    pair.estimate = first * turned * X * turned.Inverse();
    *pair.covariance += pair.common_errors * pair.common_errors.transpose();
  }
  return pairs;
}

// One number per walk: over 400 walks its square, a sixth of the sum, has a standard error of 7 % of that sixth.
TEST(Consistency, OfAnErrorThatAllFramesShareTheDifferenceCounts) {
  double second = 0, whole = 0, blind = 0;
  constexpr int kWalks = 400;
  for (uint64_t seed = 1; seed <= kWalks; ++seed) {
    std::vector<PosePair> pairs = WithACommonError(seed);
    second += MeanNees(RelativeNees(pairs, 1)) / kWalks;
    whole += MeanNees(AbsoluteNees(pairs)) / kWalks;
    for (PosePair& pair : pairs) {
      *pair.covariance -= pair.common_errors * pair.common_errors.transpose();
      pair.common_errors.resize(6, 0);
    }
    blind += MeanNees(RelativeNees(pairs, 1)) / kWalks;
  }
  EXPECT_NEAR(second, 1, 0.06);
  EXPECT_NEAR(whole, 1, 0.1);
  EXPECT_GT(blind, 1.5) << "as if there were none";
}

TEST(Consistency, WithoutCovariancesNothingIsSaid) {
  std::vector<PosePair> pairs = Odometry(1, 1);
  for (PosePair& pair : pairs) pair.covariance.reset();
  EXPECT_TRUE(AbsoluteNees(pairs).empty());
  EXPECT_TRUE(RelativeNees(pairs, 1).empty());
  EXPECT_TRUE(std::isnan(MeanNees({})));
}

}  // namespace
}  // namespace gaitcam
