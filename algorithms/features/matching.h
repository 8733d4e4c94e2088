/// Which feature of one image is which of another, judged by descriptors alone.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

struct MatchingOptions {
  double ratio =
      0.8;  ///< Nearest distance over second nearest must be below this (Lowe 2004, section 7.1); 1: no test.
  bool mutual = true;  ///< Keep only pairs that are each other's nearest.
};

struct Match {
  int a = -1, b = -1;  ///< Rows of the two descriptor matrices.
  float distance = 0;  ///< Euclidean distance of the descriptors.
};

/// Pairs each row of `a` with its nearest row of `b`, in the order of `a`; no row of `b` is used twice if `mutual`.
/// @param a, b CV_32FC1, one descriptor per row, the same number of columns; either may be empty.
std::vector<Match> MatchDescriptors(const cv::Mat& a, const cv::Mat& b, const MatchingOptions& options);

}  // namespace gaitcam
