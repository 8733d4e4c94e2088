#include "algorithms/planes/image_pyramid.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Central differences; beyond the border lies the border.
PyramidLevel LevelOf(const cv::Mat& intensity) {
  PyramidLevel level;
  level.samples.create(intensity.size(), CV_32FC3);
  const int last_u = intensity.cols - 1, last_v = intensity.rows - 1;
  for (int v = 0; v <= last_v; ++v) {
    const float* const here = intensity.ptr<float>(v);
    const float* const above = intensity.ptr<float>(std::max(v - 1, 0));
    const float* const below = intensity.ptr<float>(std::min(v + 1, last_v));
    float* to = level.samples.ptr<float>(v);
    for (int u = 0; u <= last_u; ++u, to += 3) {
      to[0] = here[u];
      to[1] = 0.5F * (here[std::min(u + 1, last_u)] - here[std::max(u - 1, 0)]);
      to[2] = 0.5F * (below[u] - above[u]);
    }
  }
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
