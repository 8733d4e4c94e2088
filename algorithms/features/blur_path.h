/// Blur along a path: its transfer function, and images whose parts have paths of their own.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// A transfer function on the frequencies of a plane's transform: row y is fy = y / height, or minus 1 from half the
/// rows on, column x is fx = x / width up to 1/2. The other half is the conjugate, as images are real.
using PlaneGain = Eigen::Array<std::complex<float>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// H(f), the mean over the exposure of exp(-2 pi i f . p(t)). Cycles per pixel; H(0) = 1.
/// @param path not empty.
PlaneGain PathTransfer(const BlurPath& path, const cv::Size& plane);
/// The same at frequencies of one's own choice: a row for each of fy, a column for each of fx.
PlaneGain PathTransfer(const BlurPath& path, const std::vector<double>& fx, const std::vector<double>& fy);

/// The same path through `count` points at equal steps of time.
BlurPath Resampled(const BlurPath& path, int count);

/// Where the light of a pixel went.
using PathAt = std::function<BlurPath(const Eigen::Vector2d& pixel)>;

struct PathDivisionOptions {
  double tolerance_px = 1;       ///< Regions are divided until a point of the path varies by less than this,
  double tolerance_share = 0.1;  ///< or by this part of the path's length,
  int min_region_px = 24;        ///< or would be smaller than this.
};

/// Cuts an image in halves until the path hardly varies over each part. Every part carries the path of its middle, with
/// confidence 1.
/// @returns regions that cover the image without overlap; one where nothing varies.
std::vector<BlurRegion> DivideByPath(const PathAt& path_at, const cv::Size& image,
                                     const PathDivisionOptions& options = {});

}  // namespace gaitcam
