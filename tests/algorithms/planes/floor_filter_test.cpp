#include "algorithms/planes/floor_filter.h"

#include <gtest/gtest.h>

#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

FloorFilterOptions Options() {
  FloorFilterOptions options;
  options.particles = 60;
  options.loop_m = 1;
  return options;
}

FloorPatch Seen(const DrawnFloor& floor, const PlanarPose& below, uint64_t seed) {
  const Pose X_WC = CameraOver(below);
  const cv::Mat image = Draw(floor, {X_WC}, 2, seed);
  const cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  const FloorFilterOptions options = Options();
  return FloorPatch::Of(ImagePyramid::Of(image, 3), mask, SmallCamera(), X_WC, options.cell_m,
                        options.range_heights * kDrawnHeight_m, options.match_points);
}

/// A circle of 3 m circumference, more than once round.
PlanarPose Round(int step) {
  const double radius_m = 3 / (2 * std::numbers::pi), angle = 2 * std::numbers::pi * step / 30;
  return {{radius_m * std::sin(angle), radius_m * (1 - std::cos(angle))}, angle};
}

struct Walked {
  double error_m = 0, path_error_m = 0;  ///< At the end; largest along the smoothed trajectory.
  double chained_error_m = 0;            ///< At the end, of the composed motions.
  int loops = 0;
};

/// Motions have 0.5 % of noise and a bias in heading: composed, they miss the beginning by centimetres.
Walked Walk(uint64_t seed, bool see, FloorFilterOptions options = Options(), int steps = 36) {
  const DrawnFloor floor(7);
  FloorFilter filter(options, seed);
  RandomStream random(seed, "test");
  PlanarPose chained;
  const double bias_deg = random.Uniform(0.03, 0.05) * (seed % 2 == 0 ? 1 : -1);
  Walked walked;
  for (int i = 0; i <= steps; ++i) {
    PlanarPose motion = i == 0 ? PlanarPose() : Round(i - 1).Inverse() * Round(i);
    if (i > 0) motion = motion * PlanarPose{{random.Normal(0, 5e-4), random.Normal(0, 5e-4)}, bias_deg / 57.3};
    chained = chained * motion;
    const Eigen::Matrix3d covariance = Eigen::Vector3d(5e-4, 5e-4, 5e-4).cwiseAbs2().asDiagonal();
    filter.Step(motion, covariance, see ? Seen(floor, Round(i), uint64_t(i)) : FloorPatch());
  }
  walked.chained_error_m = (chained.position - Round(steps).position).norm();
  walked.error_m = (filter.Mean().position - Round(steps).position).norm();
  const std::vector<PlanarPose> path = filter.SmoothPath();
  for (int i = 0; i <= steps; ++i) {
    walked.path_error_m = std::max(walked.path_error_m, (path[size_t(i)].position - Round(i).position).norm());
  }
  walked.loops = int(filter.BestLoops().size());
  return walked;
}

TEST(FloorFilter, LoopClosuresHalveTheErrorAtLeast) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const Walked walked = Walk(seed, true);
    EXPECT_GT(walked.chained_error_m, 0.01);
    EXPECT_LT(walked.error_m, 0.5 * walked.chained_error_m) << seed;
    EXPECT_LT(walked.error_m, 0.006) << seed;  // a cell
    EXPECT_LT(walked.path_error_m, walked.chained_error_m) << seed;
    EXPECT_GE(walked.loops, 3) << seed;
  }
}

TEST(FloorFilter, WeightsByDifferencesPullOnlyAsTheirReciprocal) {
  // Eq. 6.22 as it stands prefers the particles that disagree with the map: worse than no map. As a reciprocal it draws
  // the particles to the map, in this small world to a cell of 5 mm, as the likelihood does.
  double blind_m = 0, written_m = 0, reciprocal_m = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    FloorFilterOptions options = Options();
    blind_m += Walk(seed, false, options).error_m / 3;
    options.weighting = FloorWeighting::kReciprocal;
    const Walked walked = Walk(seed, true, options);
    EXPECT_EQ(walked.loops, 0);
    reciprocal_m += walked.error_m / 3;
    options.weighting = FloorWeighting::kDifferences;
    written_m += Walk(seed, true, options).error_m / 3;
  }
  EXPECT_LT(reciprocal_m, 0.7 * blind_m);
  EXPECT_LT(reciprocal_m, 0.005);
  EXPECT_GT(written_m, blind_m);
}

TEST(FloorFilter, AfterALossTheSubmapIsUncertainUntilItIsFoundInTheMap) {
  // It sees no floor for a while; then the motion is off by half a metre and 20 degrees, as its covariance allows. The
  // circle returns to known floor.
  const DrawnFloor floor(7);
  FloorFilter filter(Options(), 3);
  const Eigen::Matrix3d usual = Eigen::Vector3d(5e-4, 5e-4, 5e-4).cwiseAbs2().asDiagonal();
  const Eigen::Matrix3d guess = Eigen::Vector3d(0.4, 0.4, 0.3).cwiseAbs2().asDiagonal();
  for (int i = 0; i <= 34; ++i) {
    PlanarPose motion = i == 0 ? PlanarPose() : Round(i - 1).Inverse() * Round(i);
    const bool lost = i == 20;
    if (lost) motion = motion * PlanarPose{{0.4, -0.3}, 0.35};
    const bool blind = i > 12 && i < 20;
    filter.Step(motion, lost ? guess : usual, blind ? FloorPatch() : Seen(floor, Round(i), uint64_t(i)));
    const double error_m = (filter.Mean().position - Round(i).position).norm();
    const double sigma_m = std::sqrt(filter.Covariance().topLeftCorner<2, 2>().trace());
    if (i == 27) {
      EXPECT_EQ(filter.detached_submaps(), 1);
      EXPECT_GT(error_m, 0.2);
      EXPECT_GT(sigma_m, 0.5 * error_m);
    }
  }
  EXPECT_EQ(filter.detached_submaps(), 0);
  EXPECT_LT((filter.Mean().position - Round(34).position).norm(), 0.01);
  EXPECT_LT(std::abs(WrapAngle(filter.Mean().heading - Round(34).heading)), 0.5 / 57.3);
  EXPECT_LT(std::sqrt(filter.Covariance().topLeftCorner<2, 2>().trace()), 0.03);
}

TEST(FloorFilter, DriftBeyondTheReachOfMatchingIsFoundBySearch) {
  const DrawnFloor floor(7);
  FloorFilterOptions options = Options();
  options.drift_ratio = 0.05;
  FloorFilter filter(options, 2);
  double before_m = 0;
  for (int i = 0; i <= 36; ++i) {
    PlanarPose motion = i == 0 ? PlanarPose() : Round(i - 1).Inverse() * Round(i);
    if (i > 0) motion.position += Rotate({0.003, 0}, -Round(i - 1).heading);  // 3 %, always to one side
    filter.Step(motion, 1e-6 * Eigen::Matrix3d::Identity(), Seen(floor, Round(i), uint64_t(i)));
    if (i == 25) before_m = (filter.Mean().position - Round(i).position).norm();
  }
  EXPECT_GT(before_m, 0.06);
  EXPECT_LT((filter.Mean().position - Round(36).position).norm(), 0.01);
}

TEST(FloorFilter, WithoutImagesItComposesMotionsAndItsCovarianceGrows) {
  FloorFilter filter(Options(), 1);
  const PlanarPose motion{{0.1, 0}, 0};
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1e-3, 1e-3, 1e-3).cwiseAbs2().asDiagonal();
  double last = 0;
  for (int i = 0; i < 40; ++i) {
    filter.Step(motion, covariance, {});
    if (i % 10 != 9) continue;
    const double spread = filter.Covariance().topLeftCorner<2, 2>().trace();
    EXPECT_GT(spread, last);
    last = spread;
  }
  EXPECT_NEAR(filter.Mean().position.x(), 4.0, 3 * std::sqrt(last / Options().particles) + 0.02);
  EXPECT_TRUE(filter.BestLoops().empty());
}

TEST(FloorFilter, TheSameSeedGivesTheSameTrajectory) {
  const auto run = [](uint64_t seed) {
    const DrawnFloor floor(7);
    FloorFilter filter(Options(), seed);
    for (int i = 0; i <= 6; ++i) {
      filter.Step(i == 0 ? PlanarPose() : Round(i - 1).Inverse() * Round(i), 1e-6 * Eigen::Matrix3d::Identity(),
                  Seen(floor, Round(i), 1));
    }
    return filter.BestPath().back().position;
  };
  EXPECT_EQ(run(5), run(5));
  EXPECT_NE(run(5), run(6));
}

TEST(FloorFilter, FiveHundredParticlesOverAHundredSquareMetresFitInto300Megabytes) {
  FloorFilterOptions options = Options();
  options.particles = 500;
  FloorFilter filter(options, 1);
  const FloorPatch patch = Seen(DrawnFloor(7), {}, 1);
  // Rows of 10 m, 0.5 m apart, a keyframe each 12 cm: 1,680 of them. The patches' sizes are added, not the patches:
  // rendering them all would take minutes.
  int steps = 0;
  for (int row = 0; row < 20; ++row) {
    for (int i = 0; i < 84; ++i, ++steps) {
      const PlanarPose motion{{0.12, 0}, i == 83 ? std::numbers::pi : 0};
      filter.Step(motion, 1e-6 * Eigen::Matrix3d::Identity(), FloorPatch());
    }
  }
  const double pictures = steps * patch.bytes();
  EXPECT_LT(filter.map_bytes() + pictures, 300e6);
}

}  // namespace
}  // namespace gaitcam
