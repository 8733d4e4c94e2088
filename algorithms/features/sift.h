/// Scale-invariant features (Lowe, IJCV 2004) by OpenCV's implementation.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

struct SiftOptions {
  int max_features = 400;            ///< The strongest so many are kept.
  double contrast_threshold = 0.02;  ///< Weakest extremum of the difference of Gaussians, as OpenCV scales it.
  double edge_threshold = 10;        ///< Largest ratio of principal curvatures.
};

/// Interest points of one image; row i of `descriptors` (CV_32FC1, 128 columns) describes `pixels[i]`.
struct Features {
  std::vector<cv::Point2f> pixels;  ///< The centre of the first pixel being (0, 0).
  cv::Mat descriptors;

  int size() const { return int(pixels.size()); }
};

/// @param image CV_8UC1 or CV_8UC3 (BGR).
/// @returns the features, at most `max_features`; in an order that depends on the image alone. None in an image without
/// texture.
Features DetectSift(const cv::Mat& image, const SiftOptions& options);

}  // namespace gaitcam
