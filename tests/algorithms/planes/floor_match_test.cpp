#include "algorithms/planes/floor_match.h"

#include <gtest/gtest.h>

#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

FloorPatch SeenFrom(const DrawnFloor& floor, const PlanarPose& below, double noise_grey = 0) {
  const Pose X_WC = CameraOver(below);
  const cv::Mat image = Draw(floor, {X_WC}, noise_grey, 3);
  const cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  return FloorPatch::Of(ImagePyramid::Of(image, 3), mask, SmallCamera(), X_WC, 0.005, 0.84, 400);
}

double Rho(double e) { return 9 * std::log1p(e * e / 9); }

TEST(FloorMatch, LikelihoodOfAResidualThatAllPointsHaveIsThatResiduals) {
  const FloorPatch patch = SeenFrom(DrawnFloor(1), {});
  const std::vector<KnownFloor> known = {{&patch, {}, 0}};
  for (const double off_grey : {0.0, 4.0, 8.0, 80.0}) {
    const FloorAgreement comparison = AgreementOf(known, patch, 0, {}, 1, -off_grey, 8);
    EXPECT_GT(comparison.points, 200);
    EXPECT_NEAR(comparison.mean_rho, Rho(off_grey / 8), 1e-3) << off_grey;  // intensities are floats
    EXPECT_NEAR(comparison.correlation, 1, 1e-6);
  }
}

TEST(FloorMatch, GradientIsTheDerivativeOfTheLikelihood) {
  const DrawnFloor floor(2);
  const FloorPatch earlier = SeenFrom(floor, {}), patch = SeenFrom(floor, {{0.02, 0.01}, 0.05}, 2);
  const std::vector<KnownFloor> known = {{&earlier, {}, 0}};
  const PlanarPose pose{{0.022, 0.012}, 0.052};
  const auto cost = [&](const Eigen::Vector3d& moved, double gain, double offset) {
    const FloorAgreement c =
        AgreementOf(known, patch, 0, pose * PlanarPose{moved.head<2>(), moved[2]}, gain, offset, 8);
    return std::pair{-0.5 * c.points * c.mean_rho, c.points};
  };
  const FloorAgreement here = AgreementOf(known, patch, 0, pose, 0.95, 3, 8);
  const double step[5] = {4e-4, 4e-4, 1e-3, 1e-3, 0.05};
  for (int i = 0; i < 5; ++i) {
    Eigen::Matrix<double, 5, 1> d = Eigen::Matrix<double, 5, 1>::Zero();
    d[i] = step[i];
    const auto [up, n_up] = cost(d.head<3>(), 0.95 + d[3], 3 + d[4]);
    const auto [down, n_down] = cost(-d.head<3>(), 0.95 - d[3], 3 - d[4]);
    ASSERT_EQ(n_up, n_down) << "as many points, or their number would count";
    // Bilinear slopes jump from cell to cell: what a difference sees is their mean.
    EXPECT_NEAR((up - down) / (2 * step[i]), here.g[i], 0.1 * std::abs(here.g[i]) + 0.02 * std::sqrt(here.H(i, i)))
        << i;
  }
}

TEST(FloorMatch, FindsAShiftOfTwoCentimetresAndTwoDegreesToAMillimetre) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const DrawnFloor floor(seed);
    const PlanarPose truth{{0.3, 0.1}, 0.4};
    const FloorPatch earlier = SeenFrom(floor, {{0.25, 0.12}, 0.3}, 2), patch = SeenFrom(floor, truth, 2);
    const PlanarPose expected = truth * PlanarPose{{0.015, -0.013}, 2 / 57.3};
    const std::optional<FloorMatch> match = MatchFloor({{&earlier, {{0.25, 0.12}, 0.3}, 0}}, patch, expected, {});
    ASSERT_TRUE(match);
    const PlanarPose found = expected * PlanarPose{match->moved.head<2>(), match->moved[2]};
    const PlanarPose off = truth.Inverse() * found;
    EXPECT_LT(off.position.norm(), 0.001) << seed;
    EXPECT_LT(std::abs(off.heading), 0.2 / 57.3) << seed;
    EXPECT_GT(match->correlation, 0.9);
    // It is as sure as it should be: within 3 standard deviations.
    const Eigen::Vector3d d(off.position.x(), off.position.y(), off.heading);
    EXPECT_LT(d.dot(match->covariance.inverse() * d), 14.2) << seed;  // chi^2, 3 degrees of freedom, 99.7 %
  }
}

TEST(FloorMatch, OtherFloorDoesNotAgreeAndUnknownFloorSaysNothing) {
  const FloorPatch earlier = SeenFrom(DrawnFloor(1), {}), other = SeenFrom(DrawnFloor(2), {}, 2);
  const std::optional<FloorMatch> match = MatchFloor({{&earlier, {}, 0}}, other, {}, {});
  ASSERT_TRUE(match);
  EXPECT_LT(match->correlation, 0.8);  // FloorFilterOptions::min_correlation
  EXPECT_FALSE(MatchFloor({{&earlier, {{5, 0}, 0}, 0}}, other, {}, {}));
}

}  // namespace
}  // namespace gaitcam
