#include "algorithms/features/light_response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Grey values from 0 to 1, as they are.
cv::Mat Unchanged(const cv::Mat& grey) {
  cv::Mat light;
  grey.convertTo(light, CV_32F, 1 / 255.0);
  return light;
}

/// Mean log power around the first zero of the line's transfer function minus that around the lobe after it.
double DepthOfFirstZero(const cv::Mat& light, const LineBlur& blur) {
  constexpr double kHighest = 0.3;     // cycles per pixel; above, noise fills any trough
  constexpr double kHalfWidth = 0.15;  // of the bands, in units of the zeros' spacing
  cv::Mat window, transform;
  cv::createHanningWindow(window, light.size(), CV_32F);
  cv::Mat edges;
  cv::Laplacian(light, edges, CV_32F);  // a natural picture's spectrum is flatter after it: less leaks into the trough
  cv::dft(edges.mul(window), transform, cv::DFT_COMPLEX_OUTPUT);
  const Eigen::Vector2d v = blur.Vector();
  double zero = 0, lobe = 0;
  int zeros = 0, lobes = 0;
  for (int y = 0; y < transform.rows; ++y) {
    const double fy = double(y <= transform.rows / 2 ? y : y - transform.rows) / transform.rows;
    const float* row = transform.ptr<float>(y);
    for (int x = 1; x <= transform.cols / 2; ++x) {
      const double fx = double(x) / transform.cols, u = std::abs(fx * v.x() + fy * v.y());
      const bool is_zero = std::abs(u - 1) < kHalfWidth, is_lobe = std::abs(u - 1.5) < kHalfWidth;
      if (!(is_zero || is_lobe) || fx * fx + fy * fy > kHighest * kHighest) continue;
      const float power = row[2 * x] * row[2 * x] + row[2 * x + 1] * row[2 * x + 1];
      (is_zero ? zero : lobe) += std::log(power + 1e-12f);
      ++(is_zero ? zeros : lobes);
    }
  }
  return zeros && lobes ? zero / zeros - lobe / lobes : 0;
}

}  // namespace

cv::Mat LightOfGrey(const cv::Mat& grey) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  std::array<float, 256> light_of;
  for (size_t v = 0; v < light_of.size(); ++v) light_of[v] = float(std::pow(double(v) / 255, kResponseGamma));
  cv::Mat light;
  cv::LUT(grey, cv::Mat(1, 256, CV_32F, light_of.data()), light);
  return light;
}

cv::Mat GreyOfLight(const cv::Mat& light) {
  GAITCAM_ASSERT(light.type() == CV_32FC1);
  // A table over the root of the light, where the curve is nearly straight: exact to 1e-6.
  constexpr int kSteps = 2048;
  constexpr float kHighest = 2;  // root of the light
  std::array<float, kSteps + 2> grey_of_root;
  for (size_t i = 0; i < grey_of_root.size(); ++i)
    grey_of_root[i] = float(std::pow(double(i) * kHighest / kSteps, 2 / kResponseGamma));
  cv::Mat grey(light.size(), CV_32FC1);
  for (int y = 0; y < light.rows; ++y) {
    const float* from = light.ptr<float>(y);
    float* to = grey.ptr<float>(y);
    for (int x = 0; x < light.cols; ++x) {
      const float place = std::min(std::sqrt(std::max(from[x], 0.f)), kHighest) * (kSteps / kHighest);
      const int i = int(place);
      to[x] = grey_of_root[size_t(i)] + (place - float(i)) * (grey_of_root[size_t(i) + 1] - grey_of_root[size_t(i)]);
    }
  }
  return grey;
}

bool BlurActedOnLight(const cv::Mat& grey, const LineBlur& blur) {
  constexpr int kSide_px = 400;
  const cv::Size size(std::min(grey.cols, kSide_px), std::min(grey.rows, kSide_px));
  const cv::Mat middle = grey(cv::Rect({(grey.cols - size.width) / 2, (grey.rows - size.height) / 2}, size));
  return DepthOfFirstZero(LightOfGrey(middle), blur) < DepthOfFirstZero(Unchanged(middle), blur);
}

}  // namespace gaitcam
