#include "sim/camera/lens.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

CameraModel BarrelCamera() {
  CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 80);
  camera.k1 = -0.2;
  camera.k2 = 0.03;
  camera.p2 = 0.002;
  return camera;
}

TEST(Lens, AnIdealCameraIsDrawnAsItIs) {
  const CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 60);
  const Lens lens(camera);
  EXPECT_FALSE(lens.warps());
  EXPECT_EQ(lens.pinhole().width_px, 160);
  EXPECT_EQ(lens.pinhole().cx, camera.cx);
  const Eigen::Vector3d ray = camera.Unproject({13, 44});
  EXPECT_NEAR(lens.rays().at<cv::Vec2f>(44, 13)[0], ray.x(), 1e-6);
  EXPECT_NEAR(lens.rays().at<cv::Vec2f>(44, 13)[1], ray.y(), 1e-6);
}

TEST(Lens, TheWiderPictureHoldsEveryPixelOnItsRay) {
  CameraModel stretched = CameraModel::FromHorizontalFov(160, 120, 60);
  stretched.fy *= 1.3;  // pixels that are not square
  for (const CameraModel& camera : {BarrelCamera(), stretched}) {
    const Lens lens(camera);
    ASSERT_TRUE(lens.warps());
    EXPECT_EQ(lens.pinhole().fx, lens.pinhole().fy);
    EXPECT_FALSE(lens.pinhole().IsDistorted());
    for (int v = 0; v < 120; v += 7) {
      for (int u = 0; u < 160; u += 7) {
        const cv::Vec2f at = lens.map().at<cv::Vec2f>(v, u);
        // Room for shifted pictures, and for the neighbours that interpolation takes.
        EXPECT_GE(at[0], 1);
        EXPECT_GE(at[1], 1);
        EXPECT_LE(at[0], float(lens.pinhole().width_px - 3));
        EXPECT_LE(at[1], float(lens.pinhole().height_px - 3));
        const Eigen::Vector3d ray = lens.pinhole().Unproject({at[0], at[1]});
        EXPECT_NEAR((*camera.Project(ray) - Eigen::Vector2d(u, v)).norm(), 0, 1e-3);  // single precision
      }
    }
  }
}

TEST(Lens, DepthOfAPlaneStaysThatOfThePlane) {
  const Lens lens(BarrelCamera());
  const Eigen::Vector3d n(0.3, -0.2, 1);  // n.p = 2
  cv::Mat nearness(lens.pinhole().height_px, lens.pinhole().width_px, CV_32FC1);
  for (int v = 0; v < nearness.rows; ++v) {
    for (int u = 0; u < nearness.cols; ++u) {
      nearness.at<float>(v, u) = float(n.dot(lens.pinhole().Unproject({double(u), double(v)})) / 2);
    }
  }
  const cv::Mat warped = lens.Depth(nearness);
  for (int v = 0; v < warped.rows; ++v) {
    for (int u = 0; u < warped.cols; ++u) {
      const double z = 2 / n.dot(lens.camera().Unproject({double(u), double(v)}));
      EXPECT_NEAR(warped.at<float>(v, u), z, 1e-5 * z);
    }
  }
}

TEST(Lens, DepthIsNotMixedAcrossAnEdge) {
  const Lens lens(BarrelCamera());
  cv::Mat nearness(lens.pinhole().height_px, lens.pinhole().width_px, CV_32FC1, cv::Scalar(1));
  nearness.colRange(nearness.cols / 2, nearness.cols).setTo(cv::Scalar(1.0 / 3));
  const cv::Mat warped = lens.Depth(nearness);
  for (int i = 0; i < int(warped.total()); ++i) {
    const float z = warped.ptr<float>()[i];
    EXPECT_TRUE(std::abs(z - 1) < 1e-6 || std::abs(z - 3) < 1e-6) << z;
  }
}

TEST(Lens, RefusesDistortionWithoutAnInverse) {
  CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 100);
  camera.k1 = -0.5;
  EXPECT_THROW(Lens{camera}, BadOption);
}

}  // namespace
}  // namespace gaitcam
