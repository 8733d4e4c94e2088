/// Photographs of Debian's opencv-doc, blurred as a camera would.

#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam::psf_test {

inline cv::Mat Photograph(const std::string& name) {
  const std::string file = "/usr/share/doc/opencv-doc/examples/data/" + name;
  const cv::Mat grey = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (grey.empty()) throw std::runtime_error(file + ": missing; it belongs to Debian's package opencv-doc");
  return grey;
}

inline std::vector<std::string> PhotographNames() {
  return {"aero1.jpg", "baboon.jpg", "building.jpg", "fruits.jpg",
          "graf1.png", "home.jpg",   "leuvenA.jpg",  "messi5.jpg"};
}

/// Points of a line, 20 to a pixel, each shared between the four pixels around it; centred, sums to 1.
inline cv::Mat LineKernel(const LineBlur& blur) {
  const int radius = int(std::ceil(blur.extent_px / 2)) + 1, points = std::max(50, int(blur.extent_px * 20));
  cv::Mat kernel(2 * radius + 1, 2 * radius + 1, CV_32FC1, cv::Scalar(0));
  for (int i = 0; i < points; ++i) {
    const double t = ((i + 0.5) / points - 0.5) * blur.extent_px;
    const double x = radius + t * std::cos(blur.direction_rad), y = radius + t * std::sin(blur.direction_rad);
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    for (int v = 0; v < 2; ++v) {
      for (int u = 0; u < 2; ++u) {
        const double share = (u ? x - x0 : 1 - x + x0) * (v ? y - y0 : 1 - y + y0);
        kernel.at<float>(y0 + v, x0 + u) += float(share / points);
      }
    }
  }
  return kernel;
}

/// Blurs, then crops what the border has touched (and to at most `size` px), then adds noise and rounds.
/// @param linear_light light is added before the display's gamma of 2.2, as in a camera, instead of after it.
inline cv::Mat Blurred(const cv::Mat& grey, const LineBlur& blur, double noise, uint64_t seed,
                       bool linear_light = false, cv::Size size = {640, 480}) {
  const int margin = int(std::ceil(blur.extent_px / 2)) + 1;
  const cv::Size outer(std::min(grey.cols, size.width + 2 * margin), std::min(grey.rows, size.height + 2 * margin));
  const cv::Rect middle({(grey.cols - outer.width) / 2, (grey.rows - outer.height) / 2}, outer);
  cv::Mat values;
  grey(middle).convertTo(values, CV_32F, 1 / 255.0);
  if (linear_light) cv::pow(values, 2.2, values);
  if (blur.extent_px > 0) {
    cv::filter2D(values.clone(), values, CV_32F, LineKernel(blur), {-1, -1}, 0, cv::BORDER_REFLECT_101);
  }
  if (linear_light) {
    values = cv::max(values, 0);
    cv::pow(values, 1 / 2.2, values);
  }
  values = values(cv::Rect(margin, margin, outer.width - 2 * margin, outer.height - 2 * margin)) * 255;
  RandomStream random(seed, "noise");
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) values.at<float>(y, x) += float(random.Normal(0, noise));
  }
  cv::Mat rounded;
  values.convertTo(rounded, CV_8U);
  return rounded;
}

/// What a camera of focal length `focal_px` sees of a wall that fills its view while it turns by a rotation vector.
/// @param blur_vectors CV_32FC2: from the shutter's opening to its close.
inline cv::Mat BlurredByTurn(const cv::Mat& grey, const cv::Size& size, double focal_px, const cv::Vec3d& turn_rad,
                             double noise, uint64_t seed, cv::Mat& blur_vectors) {
  constexpr double kMargin = 1.35;  // how much more of the wall there is than the view shows
  const double scale = kMargin * std::max(double(size.width) / grey.cols, double(size.height) / grey.rows);
  cv::Mat wall;
  cv::resize(grey, wall, {}, scale, scale, scale > 1 ? cv::INTER_CUBIC : cv::INTER_AREA);
  wall.convertTo(wall, CV_32F);
  const cv::Matx33d K(focal_px, 0, (size.width - 1) / 2.0, 0, focal_px, (size.height - 1) / 2.0, 0, 0, 1);
  const cv::Matx33d K_wall(focal_px, 0, (wall.cols - 1) / 2.0, 0, focal_px, (wall.rows - 1) / 2.0, 0, 0, 1);
  const auto rotation = [&](double part) {  // maps rays of the camera now to rays of the camera at mid-exposure
    const double angle = part * cv::norm(turn_rad);
    const cv::Vec3d k = cv::norm(turn_rad) > 0 ? turn_rad / cv::norm(turn_rad) : cv::Vec3d(0, 0, 1);
    const cv::Matx33d cross(0, -k[2], k[1], k[2], 0, -k[0], -k[1], k[0], 0);
    return cv::Matx33d::eye() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
  };
  constexpr int kInstants = 80;
  cv::Mat sum(size, CV_32FC1, cv::Scalar(0)), view;
  for (int i = 0; i < kInstants; ++i) {
    const cv::Matx33d H = K_wall * rotation((i + 0.5) / kInstants - 0.5) * K.inv();
    cv::warpPerspective(wall, view, H, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
    sum += view / kInstants;
  }
  const cv::Matx33d open = K * rotation(-0.5).t() * K.inv(), close = K * rotation(0.5).t() * K.inv();
  blur_vectors.create(size, CV_32FC2);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const cv::Vec3d a = open * cv::Vec3d(x, y, 1), b = close * cv::Vec3d(x, y, 1);
      blur_vectors.at<cv::Vec2f>(y, x) = {float(b[0] / b[2] - a[0] / a[2]), float(b[1] / b[2] - a[1] / a[2])};
    }
  }
  RandomStream random(seed, "noise");
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) sum.at<float>(y, x) += float(random.Normal(0, noise));
  }
  cv::Mat rounded;
  sum.convertTo(rounded, CV_8U);
  return rounded;
}

/// The lesser of the distances to a vector and to its opposite, which is the same blur.
inline double VectorError(const Eigen::Vector2d& a, const cv::Vec2f& b) {
  const Eigen::Vector2d other{double(b[0]), double(b[1])};
  return std::min((a - other).norm(), (a + other).norm());
}

}  // namespace gaitcam::psf_test
