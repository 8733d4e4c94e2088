/// Pictures for the tests of features: everything from a seed.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// Overlapping rectangles and discs of random greys on a random ground, drawn without blur: edges at all angles,
/// CV_8UC1.
cv::Mat RandomPicture(const cv::Size& size, uint64_t seed);

/// CV_8U grey values as CV_32F, white being 1.
inline cv::Mat Values(const cv::Mat& grey) {
  cv::Mat values;
  grey.convertTo(values, CV_32F, 1 / 255.0);
  return values;
}

/// A line blur of grey values, then the frame that has seen beyond the border cut off: `margin_px` on each side.
cv::Mat BlurAndCrop(const cv::Mat& grey, const LineBlur& blur, int margin_px);

}  // namespace gaitcam
