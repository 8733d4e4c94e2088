/// Points from rays.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

/// A point seen from somewhere: it lies on the ray through (x, y, 1) of camera C.
struct RayObservation {
  Pose X_WC;
  Eigen::Vector2d xy;  ///< Normalised image coordinates (undistorted, focal length 1).
};

/// The point whose images are nearest to where it was seen (least squares in normalised image coordinates): the point
/// nearest to all rays (Hartley and Zisserman 2003, section 12.2, as least squares over ray distances), then
/// Gauss-Newton.
/// @returns nothing if the rays are next to parallel or the point lies behind a camera.
std::optional<Eigen::Vector3d> TriangulatePoint(const std::vector<RayObservation>& observations);

/// Largest angle at the point between two of its rays, rad.
double ParallaxAngle(const Eigen::Vector3d& p_W, const std::vector<RayObservation>& observations);

/// Distance between where the point was seen and where it projects, in normalised coordinates; infinity when behind.
double ReprojectionError(const Eigen::Vector3d& p_W, const RayObservation& observation);

}  // namespace gaitcam
