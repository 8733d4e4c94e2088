#include "algorithms/planes/undistortion.h"

#include <gtest/gtest.h>

#include "algorithms/core/se3.h"
#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

constexpr double kReadout_s = 0.02;

/// A camera that turns and goes as a head does in a brisk step, 0.3 m over the floor.
Pose Moving(double t_s) {
  Pose X_WC = CameraOver({{0.3 * t_s, -0.2 * t_s}, 0});
  X_WC.rotation = X_WC.rotation * ExpSo3(t_s * Eigen::Vector3d(0.8, -1.2, 1.5));
  return X_WC;
}

/// Mean difference of grey levels well inside the image.
double Difference(const cv::Mat& a, const cv::Mat& b) {
  constexpr int kMargin_px = 6;
  const cv::Rect inside(kMargin_px, kMargin_px, a.cols - 2 * kMargin_px, a.rows - 2 * kMargin_px);
  cv::Mat difference;
  cv::absdiff(a(inside), b(inside), difference);
  return cv::mean(difference)[0];
}

TEST(Undistortion, ARollingImageIsGivenAsOfTheStamp) {
  const DrawnFloor floor(11);
  const cv::Mat rolled = DrawRolling(floor, Moving, kReadout_s), at_stamp = DrawRolling(floor, Moving, 0);
  const Eigen::Vector3d up_C = Moving(0).rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const SeenAtRow seen = [&](const Eigen::Vector3d& ray_S, double row) -> Eigen::Vector3d {
    const double depth = std::min(100.0, -kDrawnHeight_m / std::min(-1e-6, up_C.dot(ray_S)));
    return Moving(kReadout_s * (row - 0.5)).Inverse() * (Moving(0) * (depth * ray_S));
  };
  const double as_rolled = Difference(rolled, at_stamp);
  EXPECT_GT(as_rolled, 4);
  // Interpolation of a texture whose shortest waves are some 15 px long, and rounding twice to whole grey levels.
  EXPECT_LT(Difference(Undistortion(SmallCamera()).Grey(rolled, seen), at_stamp), 0.1 * as_rolled);
}

TEST(Undistortion, ARollingImageThroughALensIsStraightToo) {
  CameraModel lens = SmallCamera();
  lens.k1 = -0.1;
  cv::Mat image(lens.height_px, lens.width_px, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image.at<uchar>(v, u) = cv::saturate_cast<uchar>(60 + u);
  }
  const Undistortion undistortion(lens);
  const SeenAtRow still = [](const Eigen::Vector3d& ray_S, double) -> Eigen::Vector3d { return ray_S; };
  // The one map is computed for every pixel, the other for every fourth; both interpolate the image to 1/32 px.
  EXPECT_LT(Difference(undistortion.Grey(image, still), undistortion.Grey(image)), 0.1);
}

}  // namespace
}  // namespace gaitcam
