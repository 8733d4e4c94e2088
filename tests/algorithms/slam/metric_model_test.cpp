#include "algorithms/slam/metric_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/estimate.h"
#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

/// Two models of one cloud of points, each with a descriptor of its own, seen with an error; some of them have moved in
/// between, all alike, as somebody who walks by.
struct CloudPair {
  MetricModel from, to;
  Pose X_FT;

  CloudPair(int still, int moved, double sigma_m, RandomStream& random) {
    X_FT = Pose(ExpSo3({0.02, 0.1, -0.03}), {0.1, -0.02, 0.2});
    const Eigen::Vector3d walked(0.3, 0, 0.1);
    for (int i = 0; i < still + moved; ++i) {
      const Eigen::Vector3d p_T(random.Uniform(-2, 2), random.Uniform(-1, 1), random.Uniform(2, 6));
      const Eigen::Vector3d was = i < still ? p_T : Eigen::Vector3d(p_T + walked);
      Add(to, p_T, sigma_m, i, random);
      Add(from, X_FT * was, sigma_m, i, random);
    }
  }

 private:
  static void Add(MetricModel& model, const Eigen::Vector3d& p, double sigma_m, int i, RandomStream& random) {
    const auto draw = [&] { return random.Normal(0, sigma_m); };
    model.p_C.push_back(p + Eigen::Vector3d(draw(), draw(), draw()));
    model.covariance.emplace_back(sigma_m * sigma_m * Eigen::Matrix3d::Identity());
    model.features.keypoints.emplace_back(cv::Point2f(float(100 * p.x() / p.z()), float(100 * p.y() / p.z())), 5);
    RandomStream descriptor(uint64_t(i), "descriptor");
    cv::Mat row(1, 32, CV_32FC1);
    for (float& value : cv::Mat_<float>(row)) value = float(descriptor.Normal());
    model.features.descriptors.push_back(row);
  }
};

TEST(MetricModels, AreLinkedByWhatStandsStill) {
  RandomStream random(1, "clouds");
  for (const RigidMotionMethod method : {RigidMotionMethod::kHorn, RigidMotionMethod::kMaximumLikelihood}) {
    for (int trial = 0; trial < 20; ++trial) {
      const CloudPair pair(60, 40, 0.01, random);
      ModelLinkOptions options;
      options.method = method;
      options.points_per_error = 1;
      const auto link = LinkModels(pair.from, pair.to, options, random);
      ASSERT_TRUE(link);
      EXPECT_EQ(link->matches, 100);
      // Of 60, RANSAC at 3 sigma of three dimensions leaves out 3 %: 2 expected, 9 five deviations off.
      EXPECT_GE(link->inliers, 60 - 9);
      EXPECT_LE(link->inliers, 60);
      // Chi-square of 6 degrees of freedom: one in 10^5 is beyond 33.
      const Vector6d e = Minus(pair.X_FT, link->X_FT);
      EXPECT_LT(e.dot(link->covariance.inverse() * e), 33) << trial;
      // sigma sqrt(2 / 60) of a position at the middle of the cloud, and its lever of 4 m: 1 cm is ten times the first.
      EXPECT_LT(e.head<3>().norm(), 0.02);
    }
  }
}

TEST(MetricModels, AreNotLinkedByChance) {
  RandomStream random(2, "clouds");
  CloudPair pair(40, 0, 0.01, random);
  for (Eigen::Vector3d& p : pair.to.p_C) p = {random.Uniform(-2, 2), random.Uniform(-1, 1), random.Uniform(2, 6)};
  EXPECT_FALSE(LinkModels(pair.from, pair.to, {}, random));
  EXPECT_FALSE(LinkModels(pair.from, {}, {}, random));
}

TEST(MetricModels, PutFeaturesWhereTheSceneIs) {
  Calibration calibration = OneCamera();
  calibration.has_depth = true;
  const Pose X_WC = SidewaysPose(0);
  Features features;
  for (const cv::Point2f at : {cv::Point2f(30.5F, 40.25F), {120, 90}, {200.75F, 160.5F}}) {
    features.keypoints.emplace_back(at, 4);
    features.descriptors.push_back(cv::Mat::ones(1, 8, CV_32FC1));
  }
  features.keypoints.emplace_back(cv::Point2f(239.5F, 10), 4);  // beyond the last pixel's centre
  features.descriptors.push_back(cv::Mat::zeros(1, 8, CV_32FC1));
  const MetricModel model = MakeMetricModel(features, Room().Depth(kCamera, X_WC), calibration, {});
  ASSERT_EQ(model.p_C.size(), 3u);
  ASSERT_EQ(model.features.size(), 3);
  for (size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d p_W = X_WC * model.p_C[i];
    // On the wall ahead or on the floor. A pixel of float depth at 3 m is good to 1e-6.
    EXPECT_LT(std::min(std::abs(p_W.x() - 3), std::abs(p_W.z())), 1e-4) << p_W.transpose();
    const auto seen = kCamera.Project(model.p_C[i]);
    EXPECT_LT((*seen - Eigen::Vector2d(features.keypoints[i].pt.x, features.keypoints[i].pt.y)).norm(), 1e-4);
  }
  // Nothing is farther than it may be.
  EXPECT_TRUE(MakeMetricModel(features, Room().Depth(kCamera, X_WC), calibration, {.max_depth_m = 0.5}).p_C.empty());
}

TEST(MetricModels, ADepthCamerasErrorLiesAlongTheRay) {
  Calibration calibration = OneCamera();
  calibration.depth = {0.1, 0};
  Features features;
  features.keypoints.emplace_back(cv::Point2f(60, 40), 0);
  features.descriptors = cv::Mat::ones(1, 8, CV_32FC1);
  const cv::Mat depth(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(2));
  const MetricModel model = MakeMetricModel(features, depth, calibration, {});
  const Eigen::Vector3d ray = kCamera.Unproject({60, 40});
  const double along = ray.dot(model.covariance[0] * ray) / ray.squaredNorm();
  const Eigen::Vector3d across = ray.cross(Eigen::Vector3d::UnitY()).normalized();
  EXPECT_NEAR(std::sqrt(along), 0.1 * ray.norm(), 1e-3);
  // 0.4 px of 208 at 2 m.
  EXPECT_NEAR(std::sqrt(across.dot(model.covariance[0] * across)), 2 * 0.4 / kCamera.fx, 1e-3);
}

}  // namespace
}  // namespace gaitcam
