/// Photographs of Debian's opencv-doc.

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
#include "algorithms/features/synthetic_blur.h"

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

}  // namespace gaitcam::psf_test
