#include "sim/camera/picture_difference.h"

#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {

void GreyDifference::Add(const cv::Mat& a, const cv::Mat& b, const cv::Mat& where) {
  GAITCAM_ASSERT(a.depth() == CV_8U && a.type() == b.type() && a.size() == b.size());
  const int channels = a.channels();
  for (int row = 0; row < a.rows; ++row) {
    const uint8_t *from_a = a.ptr<uint8_t>(row), *from_b = b.ptr<uint8_t>(row);
    for (int i = 0; i < a.cols * channels; ++i) {
      if (!where.empty() && where.at<uint8_t>(row, i / channels) == 0) continue;
      ++histogram_[size_t(std::abs(int(from_a[i]) - int(from_b[i])))];
    }
  }
}

double GreyDifference::rms() const {
  double count = 0, squares = 0;
  for (size_t d = 0; d < histogram_.size(); ++d) {
    count += double(histogram_[d]);
    squares += double(histogram_[d]) * double(d * d);
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

int GreyDifference::p99_9() const {
  double count = 0, below = 0;
  for (const int64_t n : histogram_) count += double(n);
  for (size_t d = 0; d < histogram_.size(); ++d) {
    below += double(histogram_[d]);
    if (below >= 0.999 * count) return int(d);
  }
  return 255;
}

cv::Mat NearDepthEdges(const cv::Mat& depth) {
  cv::Mat low, high, edges;
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  cv::erode(depth, low, cross);
  cv::dilate(depth, high, cross);
  edges = high > 1.1 * low;
  cv::dilate(edges, edges, cv::getStructuringElement(cv::MORPH_ELLIPSE, {7, 7}));
  return edges;
}

}  // namespace gaitcam
