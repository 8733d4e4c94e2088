#include "algorithms/features/synthetic_blur.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {

cv::Mat LineBlurKernel(const LineBlur& blur) {
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

cv::Mat BlurPhotograph(const cv::Mat& grey, const LineBlur& blur, double noise, uint64_t seed, bool linear_light,
                       cv::Size size) {
  const int margin = int(std::ceil(blur.extent_px / 2)) + 1;
  const cv::Size outer(std::min(grey.cols, size.width + 2 * margin), std::min(grey.rows, size.height + 2 * margin));
  const cv::Rect middle({(grey.cols - outer.width) / 2, (grey.rows - outer.height) / 2}, outer);
  cv::Mat values;
  grey(middle).convertTo(values, CV_32F, 1 / 255.0);
  if (linear_light) cv::pow(values, 2.2, values);
  if (blur.extent_px > 0) {
    cv::filter2D(values.clone(), values, CV_32F, LineBlurKernel(blur), {-1, -1}, 0, cv::BORDER_REFLECT_101);
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

double BlurVectorError(const Eigen::Vector2d& a, const cv::Vec2f& b) {
  const Eigen::Vector2d other{double(b[0]), double(b[1])};
  return std::min((a - other).norm(), (a + other).norm());
}

}  // namespace gaitcam
