/// An image and the instant it belongs to.

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace gaitcam {

/// Row 0 is the top row; the centre of the first pixel is (0, 0). 8-bit grey (CV_8UC1) or BGR (CV_8UC3);
/// depth images are CV_32FC1 in metres along the optical axis, 0 where nothing was hit.
struct Image {
  int64_t stamp_ns = 0;  ///< Middle of the exposure.
  cv::Mat pixels;
};

}  // namespace gaitcam
