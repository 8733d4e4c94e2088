/// The reference image of direct alignment, and which of its pixels are compared.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/se3.h"
#include "algorithms/planes/image_pyramid.h"

namespace gaitcam {

/// The motion that static points make in the camera's frame while the shutter is open: (rho, phi), to first order
/// rho + phi x p for a point p.
using BlurMotion = Vector6d;

/// The reference image and those of its pixels that lie on the plane.
struct PlaneReference {
  ImagePyramid pyramid;
  std::vector<std::vector<Eigen::Vector2d>> points;  ///< Per level, px of that level.
  BlurMotion blur = BlurMotion::Zero();              ///< Of the reference image.
};

/// Up to `max_points` pixels of largest gradient, spread over the image: every block of 8 x 8 px gives its best one
/// before any gives a second.
/// @param mask CV_8UC1 of level 0's size: not zero where pixels may be taken. @param k which level of the pyramid it
/// is.
std::vector<Eigen::Vector2d> SelectPixels(const PyramidLevel& level, const cv::Mat& mask, size_t k, size_t max_points);

}  // namespace gaitcam
