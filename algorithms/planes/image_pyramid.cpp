#include "algorithms/planes/image_pyramid.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

PyramidLevel LevelOf(const cv::Mat& intensity) {
  const cv::Mat kernel = (cv::Mat_<float>(1, 3) << -0.5F, 0, 0.5F);
  cv::Mat du, dv;
  cv::filter2D(intensity, du, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::filter2D(intensity, dv, CV_32F, kernel.t(), {-1, -1}, 0, cv::BORDER_REPLICATE);
  PyramidLevel level;
  cv::merge(std::vector<cv::Mat>{intensity, du, dv}, level.samples);
  return level;
}

}  // namespace

ImagePyramid ImagePyramid::Of(const cv::Mat& image, int levels) {
  GAITCAM_ASSERT(!image.empty() && levels >= 1);
  constexpr int kMinSide_px = 16;
  cv::Mat grey = image, intensity;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(intensity, CV_32F);
  ImagePyramid pyramid;
  for (int k = 0; k < levels; ++k) {
    pyramid.levels.push_back(LevelOf(intensity));
    if (std::min(intensity.cols, intensity.rows) / 2 < kMinSide_px) break;
    cv::Mat half;
    cv::pyrDown(intensity, half);
    intensity = half;
  }
  return pyramid;
}

}  // namespace gaitcam
