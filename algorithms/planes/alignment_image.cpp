#include "algorithms/planes/alignment_image.h"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// IEC 61966-2-1, for display values and light from 0 to 255.
std::array<float, 256> LightOfDisplay() {
  std::array<float, 256> table;
  for (size_t i = 0; i < table.size(); ++i) {
    const double display = double(i) / 255;
    table[i] = float(255 * (display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4)));
  }
  return table;
}

}  // namespace

cv::Mat AlignmentImage(const cv::Mat& image) {
  GAITCAM_ASSERT(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  std::array<float, 256> table = LightOfDisplay();
  cv::Mat grey = image, light;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::LUT(grey, cv::Mat(1, 256, CV_32FC1, table.data()), light);
  cv::GaussianBlur(light, light, {7, 7}, 1.0);
  return light;
}

}  // namespace gaitcam
