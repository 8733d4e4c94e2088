/// PNG files, several times as fast as libpng writes them: one filter for all rows, and libdeflate.

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// @param image 8 or 16 bits, one or three channels (BGR).
/// @param compression 0: the pixels as they are; 1 fastest to 9 smallest.
/// @returns the whole file's bytes, which depend on nothing but image and compression.
std::vector<uint8_t> EncodePng(const cv::Mat& image, int compression);

}  // namespace gaitcam
