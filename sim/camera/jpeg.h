/// Compression as a camera's own link does it: what is decoded from it is all that the system gets.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/fields.h"

namespace gaitcam {

struct JpegOptions {
  using DescribedTag = void;
  int quality = 80;
};

template <class Visitor>
void VisitFields(Visitor& visit, JpegOptions& o) {
  visit("quality", o.quality, Between(1, 100), "of libjpeg; colours have half the resolution");
}

/// @param image CV_8UC1 or CV_8UC3 (BGR). @returns the same size and type.
cv::Mat ThroughJpeg(const cv::Mat& image, const JpegOptions& options);

}  // namespace gaitcam
