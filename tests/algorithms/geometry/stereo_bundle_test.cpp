#include "algorithms/geometry/stereo_bundle.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/rig_pose.h"
#include "algorithms/geometry/rig_projection.h"

namespace gaitcam {
namespace {

constexpr double kImageSigma = 0.001;  // normalised: half a pixel at 500 px

// Five rigs side by side before a cloud of points 1 to 4 m away; images with errors, along a slanted ellipse.
struct World {
  Pose X_LR{RotY(-0.02) * RotX(0.01), {0.1, 0.002, 0}};
  std::vector<Pose> cameras;
  std::vector<Eigen::Vector3d> points;
  Eigen::Matrix2d covariance;

  explicit World(int count = 60) {
    RandomStream random(3, "stereo world");
    for (int k = 0; k < 5; ++k) {
      cameras.emplace_back(Eigen::Matrix3d(RotY(0.03 * k) * RotX(-0.01 * k)), Eigen::Vector3d(0.08 * k, 0.01 * k, 0));
    }
    for (int i = 0; i < count; ++i) {
      const double z = random.Uniform(1, 4);
      points.emplace_back(z * random.Uniform(-0.5, 0.6), z * random.Uniform(-0.4, 0.4), z);
    }
    covariance << 4, 1.2, 1.2, 1;
    covariance *= kImageSigma * kImageSigma;
  }

  Eigen::Vector2d Noise(RandomStream& random, double scale) const {
    const Eigen::Matrix2d L = covariance.llt().matrixL();
    const double x = random.Normal();
    return scale * L * Eigen::Vector2d(x, random.Normal());
  }

  StereoBundleProblem Problem(RandomStream& random, double noise) const {
    StereoBundleProblem problem;
    problem.X_LR = problem.prior_X_LR = X_LR;
    const Pose X_RL = X_LR.Inverse();
    for (size_t k = 0; k < cameras.size(); ++k) problem.cameras.push_back({cameras[k], k == 0});
    problem.points = points;
    for (size_t k = 0; k < cameras.size(); ++k) {
      for (size_t i = 0; i < points.size(); ++i) {
        for (const bool right : {false, true}) {
          const auto seen = ProjectInRig(cameras[k].Inverse(), right ? &X_RL : nullptr, points[i]);
          problem.observations.push_back({int(k), int(i), right, seen->xy + Noise(random, noise), covariance});
        }
      }
    }
    return problem;
  }
};

Vector6d SomeTangent(RandomStream& random, double size) {
  Vector6d tau;
  for (double& value : tau) value = size * random.Normal();
  return tau;
}

TEST(StereoBundle, FindsPosesPointsAndTheRigFromExactImages) {
  const World world;
  RandomStream random(1, "start");
  StereoBundleProblem problem = world.Problem(random, 0);
  for (StereoBundleCamera& camera : problem.cameras) {
    if (!camera.fixed) camera.X_WC = Plus(camera.X_WC, SomeTangent(random, 0.01));
  }
  for (Eigen::Vector3d& p : problem.points)
    p += 0.02 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
  // The prior lets the rotation go and holds the baseline, which images do not tell.
  problem.prior_covariance.diagonal() << 1e-12, 1e-12, 1e-12, 1e-2, 1e-2, 1e-2;
  problem.X_LR.rotation = problem.X_LR.rotation * ExpSo3({0.002, -0.001, 0.003});
  const StereoBundleResult result = AdjustStereoBundle(problem, {30, 2});
  EXPECT_LT(result.cost_after, 1e-6 * result.cost_before);
  for (size_t k = 0; k < world.cameras.size(); ++k) {
    EXPECT_LT(Minus(problem.cameras[k].X_WC, world.cameras[k]).norm(), 1e-6) << k;
  }
  EXPECT_LT(RotationAngle(problem.X_LR.rotation, world.X_LR.rotation), 1e-6);
  for (size_t i = 0; i < world.points.size(); ++i) EXPECT_LT((problem.points[i] - world.points[i]).norm(), 1e-5) << i;
}

// 60 trials of 6 numbers: the mean of 360 squared normals has a standard error of 7.5 %; 3.5 of these are allowed.
TEST(StereoBundle, ItsCovarianceIsThatOfItsErrors) {
  const World world;
  double nees = 0, rig_nees = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    RandomStream random(uint64_t(trial), "bundle noise");
    StereoBundleProblem problem = world.Problem(random, 1);
    problem.prior_covariance.diagonal() << 1e-12, 1e-12, 1e-12, 1e-4, 1e-4, 1e-4;
    const StereoBundleResult result = AdjustStereoBundle(problem, {20, 100});
    ASSERT_TRUE(result.has_covariance);
    const Vector6d error = Minus(problem.cameras.back().X_WC, world.cameras.back());
    nees += error.dot(result.camera_covariances.back().llt().solve(error)) / 6 / kTrials;
    const Eigen::Vector3d turn = Minus(problem.X_LR, world.X_LR).tail<3>();
    rig_nees += turn.dot(result.rig_covariance.bottomRightCorner<3, 3>().llt().solve(turn)) / 3 / kTrials;
  }
  EXPECT_NEAR(nees, 1, 0.26);
  EXPECT_NEAR(rig_nees, 1, 0.37);  // of 180 numbers
}

TEST(StereoBundle, AFixedRigStaysAsItIs) {
  const World world;
  RandomStream random(1, "fixed");
  StereoBundleProblem problem = world.Problem(random, 1);
  const StereoBundleResult result = AdjustStereoBundle(problem, {});
  EXPECT_EQ(problem.X_LR.rotation.coeffs(), world.X_LR.rotation.coeffs());
  EXPECT_TRUE(result.rig_covariance.isZero(0));
  EXPECT_TRUE(result.camera_covariances.front().isZero(0)) << "the world's";
}

TEST(StereoBundle, APointThatItsImagesLeaveOpenCostsNoCovariance) {
  const World world;
  RandomStream random(1, "open"), again(1, "open");
  StereoBundleProblem closed = world.Problem(random, 1), open = world.Problem(again, 1);
  open.points.emplace_back(0.1, 0.2, 2);  // one image tells no distance
  open.observations.push_back({1, int(open.points.size()) - 1, false, {0.05, 0.1}, world.covariance});
  const StereoBundleResult expected = AdjustStereoBundle(closed, {40, 100}),
                           result = AdjustStereoBundle(open, {40, 100});
  ASSERT_TRUE(result.has_covariance);
  for (size_t k = 0; k < world.cameras.size(); ++k) {  // 1e-3: the minimum is found to so much
    const Matrix6d& of_closed = expected.camera_covariances[k];
    EXPECT_LE((result.camera_covariances[k] - of_closed).norm(), 1e-3 * of_closed.norm()) << k;
    const Matrix6d& own = expected.own_covariances[k];
    EXPECT_LE((result.own_covariances[k] - own).norm(), 1e-3 * own.norm()) << "no other camera sees it";
  }
  EXPECT_NE(result.point_covariances.back().llt().info(), Eigen::Success);
}

TEST(StereoBundle, OfEachCovarianceTheOwnImagesArePart) {
  const World world;
  RandomStream random(1, "own");
  StereoBundleProblem problem = world.Problem(random, 1);
  const StereoBundleResult result = AdjustStereoBundle(problem, {});
  const Matrix6d& of_fixed = result.own_covariances.front();
  EXPECT_EQ(of_fixed.llt().info(), Eigen::Success);
  for (size_t k = 1; k < world.cameras.size(); ++k) {
    const Matrix6d& own = result.own_covariances[k];
    EXPECT_EQ(own.llt().info(), Eigen::Success);
    EXPECT_NEAR(own.norm(), of_fixed.norm(), 0.5 * of_fixed.norm()) << "alike: they see the same from 8 cm apart";
    const Matrix6d rest = result.camera_covariances[k] - own;
    EXPECT_GE((rest + 1e-9 * own.norm() * Matrix6d::Identity()).ldlt().vectorD().minCoeff(), 0) << k;
  }
}

// Sightings of the world's points, each point known with an error of its own.
std::vector<RigSighting> RigSightings(const World& world, const Pose& X_WC, RandomStream& of_points,
                                      RandomStream& of_images) {
  const Eigen::Matrix3d of_point = Eigen::Vector3d(1e-4, 1e-4, 9e-4).asDiagonal();
  const Pose X_RL = world.X_LR.Inverse();
  std::vector<RigSighting> sightings;
  for (const Eigen::Vector3d& p : world.points) {
    const auto left = ProjectInRig(X_WC.Inverse(), nullptr, p), right = ProjectInRig(X_WC.Inverse(), &X_RL, p);
    RigSighting sighting{p, of_point, left->xy + world.Noise(of_images, 1), world.covariance};
    for (int k = 0; k < 3; ++k) sighting.p_W[k] += std::sqrt(of_point(k, k)) * of_points.Normal();
    sighting.has_right = true;
    sighting.right = right->xy + world.Noise(of_images, 1);
    sighting.covariance_right = world.covariance;
    sightings.push_back(sighting);
  }
  return sightings;
}

RigPosePrior Wide(const Pose& X_WC) { return {X_WC, 1, 1}; }

TEST(RigPose, ItsCovarianceIsThatOfItsErrorsAndSoIsItsOwnPart) {
  const World world;
  const Pose truth = world.cameras[2];
  RigPoseOptions options;
  options.outlier_sigmas = 10;
  options.huber = 10;
  constexpr int kTrials = 60;
  double nees = 0, own = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<RigPoseResult> twins;  // of the same points, with other images
    for (const uint64_t image : {1u, 2u}) {
      RandomStream of_points(uint64_t(trial), "points"), of_images(10 * uint64_t(trial) + image, "images");
      const auto found =
          RefineRigPose(RigSightings(world, truth, of_points, of_images), world.X_LR, truth, Wide(truth), 15, options);
      ASSERT_TRUE(found);
      twins.push_back(*found);
    }
    const Vector6d error = Minus(twins[0].X_WC, truth), apart = Minus(twins[0].X_WC, twins[1].X_WC);
    nees += error.dot(twins[0].covariance.llt().solve(error)) / 6 / kTrials;
    const Matrix6d of_both = twins[0].covariance_own + twins[1].covariance_own;
    own += apart.dot(of_both.llt().solve(apart)) / 6 / kTrials;
  }
  EXPECT_NEAR(nees, 1, 0.26);
  EXPECT_NEAR(own, 1, 0.26) << "what the points have wrong is common to both and cancels";
}

TEST(RigPose, IsFoundAmongMismatchesAndSaysWhichTheyAre) {
  const World world(120);
  RandomStream of_points(1, "points"), of_images(1, "images"), random(1, "ransac");
  std::vector<RigSighting> sightings = RigSightings(world, world.cameras[1], of_points, of_images);
  for (size_t i = 0; i < sightings.size(); i += 3)
    sightings[i].left = {random.Uniform(-0.5, 0.5), random.Uniform(-0.4, 0.4)};
  for (size_t i = 1; i < sightings.size(); i += 9) sightings[i].right.x() += 0.1;
  const auto found = EstimateRigPose(sightings, world.X_LR, Wide(Pose()), 15, {}, random);
  ASSERT_TRUE(found);
  EXPECT_LT(Minus(found->X_WC, world.cameras[1]).norm(), 0.01);
  for (size_t i = 0; i < sightings.size(); ++i) {
    if (i % 3 == 0) {
      EXPECT_EQ(found->use[i], SightingUse::kNone) << i;
    } else if (i % 9 == 1) {
      EXPECT_NE(found->use[i], SightingUse::kBoth) << i << ": the left image alone may be right";
    }
  }
}

TEST(RigPose, IsNotLookedForWhereItCannotBe) {
  const World world;
  RandomStream of_points(1, "points"), of_images(1, "images"), random(1, "ransac");
  const auto sightings = RigSightings(world, world.cameras[4], of_points, of_images);
  const auto estimate = [&](double sigma) {
    return EstimateRigPose(sightings, world.X_LR, {Pose(), sigma, sigma}, 15, {}, random);
  };
  EXPECT_TRUE(estimate(0.1)) << "32 cm away";
  EXPECT_FALSE(estimate(0.01));
}

TEST(RigPose, TooFewSightingsGiveNone) {
  const World world(10);
  RandomStream of_points(1, "points"), of_images(1, "images"), random(1, "ransac");
  const auto sightings = RigSightings(world, world.cameras[1], of_points, of_images);
  EXPECT_FALSE(EstimateRigPose(sightings, world.X_LR, Wide(Pose()), 15, {}, random));
}

}  // namespace
}  // namespace gaitcam
