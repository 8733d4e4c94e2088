/// What a depth image says between its pixels.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace gaitcam {

/// Depth between pixels' centres: its inverse is linear on a plane. @returns nothing outside the image, where one of
/// the four pixels has no depth, or where they lie on different surfaces (further apart than 5 %).
/// @param depth CV_32FC1, m along the optical axis; 0 where nothing is known.
std::optional<double> DepthAt(const cv::Mat& depth, const Eigen::Vector2d& pixel);

}  // namespace gaitcam
