#include "algorithms/geometry/inverse_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gaitcam {
namespace {

constexpr double kSigma = 0.002;  // half a pixel of a small camera
constexpr double kField = 0.1;    // solid angle of 10 degrees around

// A camera that has turned by `turn` and moved by `shift` sees points 1 to 4 away; of them `wrong` anything nearby.
std::vector<InverseDepthSighting> Sightings(const Pose& X_WC, int right, int wrong) {
  RandomStream random(1, "sightings");
  std::vector<InverseDepthSighting> sightings;
  for (int i = 0; i < right + wrong; ++i) {
    InverseDepthPoint point{Pose(), {random.Uniform(-0.4, 0.4), random.Uniform(-0.3, 0.3)}, kSigma, 0, 0};
    point.rho = 1 / random.Uniform(1, 4);
    Eigen::Vector2d xy = *ProjectInverseDepth(point.X_WA, point.xy, point.rho, X_WC);
    const double noise = i < right ? kSigma : 0.09;
    sightings.push_back({point, xy + noise * Eigen::Vector2d(random.Normal(), random.Normal()), kSigma});
  }
  return sightings;
}

Eigen::Quaterniond Turned() {
  return Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.3, 1, 0.2).normalized()));
}

TEST(EstimateTurn, TwelveOfSeventyAgree) {
  const Pose C(Turned(), {0.01, -0.005, 0.01});
  RandomStream random(2, "turn");
  const auto sightings = Sightings(C, 12, 58);
  const TurnResult found =
      EstimateTurn(sightings, {Eigen::Vector3d::Zero(), 0.015}, Eigen::Quaterniond::Identity(), kField, random);
  EXPECT_LT(RotationAngle(found.X_WC.rotation, C.rotation), 0.02);  // points 1 away shift by 0.015
  int right = 0;
  for (const int i : found.inliers) right += i < 12;
  EXPECT_GE(right, 9);
  EXPECT_GT(double(found.inliers.size()), found.chance + 4 * std::sqrt(found.chance));
}

TEST(EstimateTurn, OfFalseSightingsHardlyMoreAgreeThanByChance) {
  RandomStream random(3, "turn");
  const auto sightings = Sightings(Pose(Turned(), Eigen::Vector3d::Zero()), 0, 200);
  const TurnResult found =
      EstimateTurn(sightings, {Eigen::Vector3d::Zero(), 0.015}, Eigen::Quaterniond::Identity(), kField, random);
  EXPECT_GT(found.chance, 1);
  EXPECT_LT(double(found.inliers.size()), found.chance + 6 * std::sqrt(found.chance)) << "the best of many turns";
}

TEST(EstimateTurn, TwoSightingsAreNoAgreement) {
  RandomStream random(4, "turn");
  const TurnResult found =
      EstimateTurn(Sightings(Pose(), 2, 0), {Eigen::Vector3d::Zero(), 0.01}, Turned(), 0.1, random);
  EXPECT_TRUE(found.inliers.empty());
  EXPECT_TRUE(found.X_WC.Matrix().allFinite());
}

TEST(RefinePose, WherePointsTellNothingThePriorDecides) {
  std::vector<InverseDepthSighting> sightings = Sightings(Pose(), 40, 0);
  std::vector<int> all;
  for (int i = 0; i < 40; ++i) {
    sightings[size_t(i)].point.rho = 0;  // stars
    all.push_back(i);
  }
  const Eigen::Vector3d expected(0.3, 0.2, -0.1);
  const Pose found = RefinePose(sightings, all, Pose(), 2, PositionPrior{expected, 0.05});
  EXPECT_LT((found.translation - expected).norm(), 1e-4);
}

TEST(RefinePose, GoodSightingsOutvoteAWrongPrior) {
  const Pose C(Turned(), {0.2, 0, 0});
  const std::vector<InverseDepthSighting> sightings = Sightings(C, 200, 0);
  std::vector<int> all;
  for (int i = 0; i < 200; ++i) all.push_back(i);
  const Pose found = RefinePose(sightings, all, C, 2, PositionPrior{Eigen::Vector3d::Zero(), 0.1});
  EXPECT_LT((found.translation - C.translation).norm(), 0.01);  // some sigma / sqrt(200) of points 2 away
}

TEST(RefinePosition, FindsTheBestPositionAndHoldsTheRotation) {
  const Pose C(Turned(), {0.2, 0, 0});
  const std::vector<InverseDepthSighting> sightings = Sightings(C, 200, 0);
  std::vector<int> all;
  for (int i = 0; i < 200; ++i) all.push_back(i);
  const Pose found = RefinePosition(sightings, all, Pose(C.rotation, {0, 0.1, 0.1}), 2);
  EXPECT_EQ(found.rotation.coeffs(), C.rotation.coeffs());
  EXPECT_LT((found.translation - C.translation).norm(), 0.01);  // as above
  const Eigen::Quaterniond wrong = C.rotation * ExpSo3({0, 0.02, 0});
  const Pose shifted = RefinePosition(sightings, all, Pose(wrong, C.translation), 2);
  EXPECT_NEAR(RotationAngle(shifted.rotation, wrong), 0, 1e-12);
  EXPECT_GT((shifted.translation - C.translation).norm(), 0.02) << "to the side, as a turn looks like";
}

/// A camera that has just turned to a wall: most points are new, and their depth is assumed.
TEST(RefinePose, AssumedDepthsTogetherCountAsOne) {
  const Pose C(Turned(), {0.08, 0, 0.06});
  std::vector<InverseDepthSighting> sightings = Sightings(C, 250, 0);
  std::vector<int> all;
  for (int i = 0; i < 250; ++i) all.push_back(i);
  for (size_t i = 25; i < 250; ++i) {
    sightings[i].point.rho = sightings[i].point.rho_sigma = 3;  // three to twelve times too near
    sightings[i].point.is_guess = true;
  }
  const Eigen::Vector3d expected = 0.7 * C.translation;
  const Pose found = RefinePose(sightings, all, Pose(Turned(), expected), 2, PositionPrior{expected, 0.1});
  EXPECT_LT((found.translation - C.translation).norm(), 0.01);  // a tenth; sigma / sqrt(25) of points 2 away: 0.001
}

}  // namespace
}  // namespace gaitcam
