#include "scenarios/code/datasets/floor_intrinsics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

constexpr double kDeg = M_PI / 180;

/// 0.3 m above the floor, looking forward and down.
Pose Head(double pitch_deg, double roll_deg) {
  Eigen::Matrix3d forward;  // camera x right, y down, z forward
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Pose(forward * RotX(-pitch_deg * kDeg) * RotZ(roll_deg * kDeg), {0.1, 0.2, 0.3});
}

/// What lies at each pixel: the floor, or a wall 2 m ahead.
cv::Mat DepthOfFloorAndWall(const CameraModel& camera, const Pose& X_WC) {
  cv::Mat depth(camera.height_px, camera.width_px, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray = X_WC.R() * camera.Unproject({double(u), double(v)});
      const double wall = (2 - X_WC.translation.x()) / ray.x(), floor = -X_WC.translation.z() / ray.z();
      depth.at<float>(v, u) = float(floor > 0 ? std::min(wall, floor) : wall);
    }
  }
  return depth;
}

FloorIntrinsics FitOf(const CameraModel& filmed, const CameraModel& told) {
  FloorFit fit(told);
  for (int i = 0; i < 8; ++i) {
    const Pose X_WC = Head(10 + i, 3 * std::sin(i));  // a walking head rolls some degrees
    fit.Add(X_WC, DepthOfFloorAndWall(filmed, X_WC));
  }
  const auto found = fit.Fit();
  EXPECT_TRUE(found);
  return found.value_or(FloorIntrinsics());
}

TEST(FloorIntrinsics, TheFloorTellsTheFocalLengthsThatFilmedIt) {
  CameraModel filmed = CameraModel::FromHorizontalFov(320, 240, 60);
  filmed.fy *= 1.01;
  for (const double factor : {0.95, 0.98, 1.0, 1.02, 1.05}) {
    CameraModel told = filmed;
    told.fx *= factor;
    told.fy *= factor;
    const FloorIntrinsics found = FitOf(filmed, told);
    EXPECT_NEAR(found.fx / filmed.fx, 1, 1e-4) << factor;  // depth has 24 bits: 1e-7
    EXPECT_NEAR(found.fy / filmed.fy, 1, 1e-4) << factor;
    EXPECT_LT(found.fx_std / found.fx, 1e-3);
    EXPECT_LT(found.rms_m, 5e-4);  // the wall's lowest 2 mm count as floor
  }
}

TEST(FloorIntrinsics, ADistortedLensIsNoObstacle) {
  CameraModel filmed = CameraModel::FromHorizontalFov(320, 240, 80);
  filmed.k1 = -0.2;
  filmed.k2 = 0.03;
  const FloorIntrinsics found = FitOf(filmed, filmed);
  EXPECT_NEAR(found.fx / filmed.fx, 1, 1e-4);
  EXPECT_NEAR(found.fy / filmed.fy, 1, 1e-4);
}

TEST(FloorIntrinsics, ALevelHeadDoesNotTellTheWidthAndSaysSo) {
  const CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  FloorFit fit(camera);
  const Pose X_WC = Head(12, 0);  // without roll, x does not move a point's height
  cv::Mat depth = DepthOfFloorAndWall(camera, X_WC);
  cv::Mat noise(depth.size(), CV_32FC1);
  cv::theRNG().state = 7;
  cv::randn(noise, 0, 1e-3);
  fit.Add(X_WC, depth + noise);
  const auto found = fit.Fit();
  if (found) {
    EXPECT_GT(found->fx_std / found->fx, 0.01);
  }
}

TEST(FloorIntrinsics, WithoutAFloorInViewNothingIsSaid) {
  const CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  FloorFit fit(camera);
  const Pose X_WC = Head(-40, 2);
  const cv::Mat depth = DepthOfFloorAndWall(camera, X_WC);
  fit.Add(X_WC, depth);
  EXPECT_FALSE(fit.Fit());
  EXPECT_FALSE(FloorFit::FloorHeight(camera, X_WC, depth));
}

TEST(FloorIntrinsics, APoseThatIsTooHighLiftsTheFloor) {
  const CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  Pose X_WC = Head(12, 1);
  const cv::Mat depth = DepthOfFloorAndWall(camera, X_WC);
  EXPECT_LT(FloorFit::FloorHeight(camera, X_WC, depth).value(), 1e-5);
  X_WC.translation.z() += 0.01;
  EXPECT_NEAR(FloorFit::FloorHeight(camera, X_WC, depth).value(), 0.01, 1e-5);
}

}  // namespace
}  // namespace gaitcam
