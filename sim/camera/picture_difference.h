/// How far pictures of the same instant differ: the measure of how exactly light was integrated.

#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace gaitcam {

/// Differences of pictures, in grey levels.
class GreyDifference {
 public:
  /// @param where CV_8UC1 of the pictures' size: only where it is not 0; empty: everywhere.
  void Add(const cv::Mat& a, const cv::Mat& b, const cv::Mat& where = cv::Mat());
  double rms() const;
  /// A thousandth of all values differs by more.
  int p99_9() const;

 private:
  std::array<int64_t, 256> histogram_{};
};

/// CV_8UC1: 255 within 3 px of a depth edge, 0 elsewhere. @param depth CV_32FC1, m.
cv::Mat NearDepthEdges(const cv::Mat& depth);

}  // namespace gaitcam
