#include "algorithms/features/scale_space.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Smooths from one scale to a larger one; what is there already only needs the difference of the variances.
cv::Mat Smooth(const cv::Mat& light, double from, double to) {
  const double sigma = std::sqrt(std::max(to * to - from * from, 0.0));
  if (sigma < 0.1) return light.clone();
  cv::Mat smooth;
  cv::GaussianBlur(light, smooth, cv::Size(), sigma, sigma, cv::BORDER_REFLECT_101);
  return smooth;
}

/// Twice the resolution. Its first pixel's centre lies a quarter of a pixel left of and above the image's.
cv::Mat Doubled(const cv::Mat& image) {
  cv::Mat doubled;
  cv::resize(image, doubled, cv::Size(), 2, 2, cv::INTER_LINEAR);
  return doubled;
}

cv::Mat EverySecondPixel(const cv::Mat& light) {
  cv::Mat half((light.rows + 1) / 2, (light.cols + 1) / 2, CV_32FC1);
  for (int y = 0; y < half.rows; ++y) {
    const float* from = light.ptr<float>(2 * y);
    float* to = half.ptr<float>(y);
    for (int x = 0; x < half.cols; ++x) to[x] = from[2 * x];
  }
  return half;
}

bool TooSmall(const cv::Mat& light) { return std::min(light.rows, light.cols) < kMinOctavePx; }

}  // namespace

std::vector<double> LevelScales(const ScaleSpaceOptions& options) {
  std::vector<double> scales;
  for (int i = 0; i < options.intervals + 2; ++i)
    scales.push_back(options.sigma * std::exp2(double(i) / options.intervals));
  return scales;
}

ScaleSpace BuildScaleSpace(const cv::Mat& image, const ScaleSpaceOptions& options) {
  GAITCAM_ASSERT(image.type() == CV_32FC1);
  CheckFields(options);
  const std::vector<double> scales = LevelScales(options);
  ScaleSpace space;
  if (image.empty() || TooSmall(image)) return space;
  cv::Mat first = options.first_doubled ? Doubled(image) : image;
  double pitch_px = options.first_doubled ? 0.5 : 1.0;
  const double origin_px = options.first_doubled ? -0.25 : 0.0;
  double have = options.camera_sigma / pitch_px;
  for (int o = 0; o < options.octaves && !TooSmall(first); ++o) {
    ScaleOctave octave{pitch_px, origin_px, {}};
    for (const double scale : scales) {
      octave.levels.push_back({scale, Smooth(octave.levels.empty() ? first : octave.levels.back().light, have, scale)});
      have = scale;
    }
    first = EverySecondPixel(octave.levels[size_t(options.intervals)].light);
    have = options.sigma;
    pitch_px *= 2;
    space.push_back(std::move(octave));
  }
  return space;
}

}  // namespace gaitcam
