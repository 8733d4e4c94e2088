#include "algorithms/geometry/depth_image.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

/// Of a plane whose inverse depth grows to the right and downwards.
double OnPlane(double u, double v) { return 1 / (0.3 + 0.003 * u + 0.005 * v); }

cv::Mat Plane() {
  cv::Mat depth(8, 10, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) depth.at<float>(v, u) = float(OnPlane(u, v));
  }
  return depth;
}

TEST(DepthImage, IsExactBetweenPixelsOfAPlane) {
  const cv::Mat depth = Plane();
  for (const Eigen::Vector2d pixel : {Eigen::Vector2d(2, 3), {2.5, 3.25}, {7.9, 5.1}, {0, 0}}) {
    const auto z = DepthAt(depth, pixel);
    ASSERT_TRUE(z);
    EXPECT_NEAR(*z, OnPlane(pixel.x(), pixel.y()), 1e-6);  // pixels are floats
  }
}

TEST(DepthImage, SaysNothingAtEdgesHolesAndOutside) {
  cv::Mat depth = Plane();
  for (const Eigen::Vector2d pixel : {Eigen::Vector2d(-0.1, 3), {9.1, 3}, {3, 7.1}, {NAN, 2}})
    EXPECT_FALSE(DepthAt(depth, pixel)) << pixel.transpose();
  depth.at<float>(3, 5) = 0;
  EXPECT_FALSE(DepthAt(depth, {4.5, 3.5}));
  EXPECT_TRUE(DepthAt(depth, {2.5, 3.5}));
  depth.at<float>(3, 5) = 1.06F * depth.at<float>(3, 4) * 1.1F;  // another surface behind
  EXPECT_FALSE(DepthAt(depth, {4.5, 3.5}));
}

}  // namespace
}  // namespace gaitcam
