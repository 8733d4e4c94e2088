#include "algorithms/geometry/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/inverse_depth.h"

namespace gaitcam {
namespace {

Pose Moved(const Pose& pose, RandomStream& random, double turn, double shift) {
  const auto noise = [&](double s) {
    return Eigen::Vector3d(random.Normal(0, s), random.Normal(0, s), random.Normal(0, s));
  };
  const Eigen::Quaterniond rotation = ExpSo3(noise(turn));
  return pose * Pose(rotation, noise(shift));
}

TEST(InverseDepth, DerivativesAreThoseOfFiniteDifferences) {
  RandomStream random(1, "poses");
  const Pose A = Moved(Pose(), random, 0.3, 0.5), C = Moved(Pose(), random, 0.3, 0.5);
  const Eigen::Vector2d xy(0.2, -0.1);
  const double rho = 0.4, h = 1e-6;
  const auto at = LinearizeInverseDepth(A, xy, rho, C);
  ASSERT_TRUE(at);
  const auto moved = [](const Pose& pose, int k, double s) { return Plus(pose, s * Vector6d::Unit(k)); };
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector2d anchor =
        (*ProjectInverseDepth(moved(A, k, h), xy, rho, C) - *ProjectInverseDepth(moved(A, k, -h), xy, rho, C)) /
        (2 * h);
    const Eigen::Vector2d camera =
        (*ProjectInverseDepth(A, xy, rho, moved(C, k, h)) - *ProjectInverseDepth(A, xy, rho, moved(C, k, -h))) /
        (2 * h);
    EXPECT_LT((anchor - at->d_anchor.col(k)).norm(), 1e-7) << k;  // central differences of step 1e-6
    EXPECT_LT((camera - at->d_camera.col(k)).norm(), 1e-7) << k;
  }
  const Eigen::Vector2d depth =
      (*ProjectInverseDepth(A, xy, rho + h, C) - *ProjectInverseDepth(A, xy, rho - h, C)) / (2 * h);
  EXPECT_LT((depth - at->d_rho).norm(), 1e-7);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d e = h * Eigen::Vector2d::Unit(k);
    const Eigen::Vector2d ray =
        (*ProjectInverseDepth(A, xy + e, rho, C) - *ProjectInverseDepth(A, xy - e, rho, C)) / (2 * h);
    EXPECT_LT((ray - at->d_xy.col(k)).norm(), 1e-7);
  }
}

TEST(InverseDepth, APointAtInfinityDoesNotMoveWithTheCamera) {
  const Pose C(Eigen::Quaterniond::Identity(), Eigen::Vector3d(3, 2, 1));
  EXPECT_LT((*ProjectInverseDepth(Pose(), {0.1, 0.2}, 0, C) - Eigen::Vector2d(0.1, 0.2)).norm(), 1e-15);
}

TEST(InverseDepth, APointBehindTheCameraHasNoImage) {
  const Pose behind(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY())), Eigen::Vector3d::Zero());
  EXPECT_FALSE(ProjectInverseDepth(Pose(), {0, 0}, 1, behind));
}

TEST(InverseDepth, PointsOfUnknownDepthGiveTheTurnAndLeaveTheDepthOpen) {
  RandomStream random(2, "rays");
  const Pose C(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.2, 1, 0.1).normalized())),
               Eigen::Vector3d::Zero());
  std::vector<InverseDepthSighting> sightings;
  std::vector<int> all;
  for (int i = 0; i < 50; ++i) {
    InverseDepthPoint point{Pose(), {random.Uniform(-0.4, 0.4), random.Uniform(-0.3, 0.3)}, 0, 1, 1};
    sightings.push_back({point, *ProjectInverseDepth(point.X_WA, point.xy, 0.3, C), 0.002});
    all.push_back(i);
  }
  EXPECT_LT(RotationAngle(RefinePose(sightings, all, Pose(), 2).rotation, C.rotation), 1e-4);
}

struct BundleScene {
  BundleProblem truth, noisy;
};

/// Eight cameras on a line, the first two held; 60 points, every camera sees all.
BundleScene MakeScene(double sigma, int wrong) {
  RandomStream random(3, "bundle");
  BundleScene scene;
  for (int k = 0; k < 8; ++k) {
    scene.truth.cameras.push_back(
        {Moved(Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1 * k, 0, 0)), random, 0.02, 0.02), k < 2});
  }
  scene.noisy.cameras = scene.truth.cameras;
  for (size_t k = 2; k < 8; ++k) scene.noisy.cameras[k].X_WC = Moved(scene.truth.cameras[k].X_WC, random, 0.01, 0.02);
  for (int i = 0; i < 60; ++i) {
    BundlePoint point;
    point.ray = {random.Uniform(-0.4, 0.4), random.Uniform(-0.3, 0.3)};
    point.rho = random.Uniform(0.2, 1);
    point.sigma = std::max(sigma, 1e-6);
    point.prior_rho = 0.5;
    point.prior_sigma = 5;
    point.xy = point.ray + sigma * Eigen::Vector2d(random.Normal(), random.Normal());
    scene.truth.points.push_back(point);
    for (int k = 1; k < 8; ++k) {
      Eigen::Vector2d xy =
          *ProjectInverseDepth(scene.truth.cameras[0].X_WC, point.ray, point.rho, scene.truth.cameras[size_t(k)].X_WC);
      xy += sigma * Eigen::Vector2d(random.Normal(), random.Normal());
      if (i < wrong && k == 4) xy.x() += 0.1;
      scene.noisy.observations.push_back({k, i, xy, std::max(sigma, 1e-6)});
    }
    point.ray = point.xy;
    point.rho = point.prior_rho;
    scene.noisy.points.push_back(point);
  }
  return scene;
}

double WorstPosition(const BundleScene& scene) {
  double worst = 0;
  for (size_t k = 0; k < 8; ++k) {
    worst = std::max(worst, (scene.noisy.cameras[k].X_WC.translation - scene.truth.cameras[k].X_WC.translation).norm());
  }
  return worst;
}

TEST(BundleAdjustment, ExactSightingsGiveTheExactScene) {
  BundleScene scene = MakeScene(0, 0);
  BundleOptions options;
  options.max_iterations = 50;
  AdjustBundle(scene.noisy, options);
  EXPECT_LT(WorstPosition(scene), 1e-6);
  for (size_t i = 0; i < 60; ++i) EXPECT_NEAR(scene.noisy.points[i].rho, scene.truth.points[i].rho, 1e-6);
}

TEST(BundleAdjustment, NoiseAndSomeWrongSightingsAreBorne) {
  BundleScene scene = MakeScene(0.002, 6);
  BundleOptions options;
  options.max_iterations = 50;
  const BundleResult result = AdjustBundle(scene.noisy, options);
  EXPECT_LT(result.cost_after, result.cost_before);
  EXPECT_LT(WorstPosition(scene), 0.01);  // 0.002 at depths of 1 to 5 over 60 points
  std::vector<double> errors;             // in stated standard deviations
  for (size_t i = 6; i < 60; ++i) {
    const BundlePoint& point = scene.noisy.points[i];
    errors.push_back(std::abs(point.rho - scene.truth.points[i].rho) / point.rho_sigma);
  }
  std::nth_element(errors.begin(), errors.begin() + 27, errors.end());
  EXPECT_LT(errors[27], 2) << "0.67 if the cameras were known, whose own errors are left out";
  EXPECT_GT(errors[27], 0.3);
}

TEST(BundleAdjustment, FixedCamerasStayToTheBitAndRunsAreTheSame) {
  BundleScene a = MakeScene(0.002, 3), b = MakeScene(0.002, 3);
  AdjustBundle(a.noisy, {});
  AdjustBundle(b.noisy, {});
  for (size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(a.noisy.cameras[k].X_WC.translation, b.noisy.cameras[k].X_WC.translation);
    if (k < 2) {
      EXPECT_EQ(a.noisy.cameras[k].X_WC.translation, a.truth.cameras[k].X_WC.translation);
    }
  }
}

}  // namespace
}  // namespace gaitcam
