/// The error of a position that a covariance states, as ellipses for a drawing seen from above.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "algorithms/core/se3.h"

namespace gaitcam::internal {

/// A horizontal section of 95 % probability.
struct PositionEllipse {
  Eigen::Vector2d axes_m;  ///< Semi-axes, the larger first.
  double turn_rad = 0;     ///< From the world's x to the larger one, counterclockwise.
};

/// @param R_WC the camera's orientation in the world of the drawing
/// @param covariance of its pose, in the tangent of se3.h
PositionEllipse EllipseOf(const Eigen::Quaterniond& R_WC, const Matrix6d& covariance);

/// Ellipses are drawn so many times their true size that the median one can be seen: 1, 2, 5, 10, ...
/// @param unit_m a hundredth of the drawing's side
double EllipseMagnification(const std::vector<PositionEllipse>& ellipses, double unit_m);

}  // namespace gaitcam::internal
