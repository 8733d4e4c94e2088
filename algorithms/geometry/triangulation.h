/// Triangulation of points.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

/// An observation of a point: it lies on the ray through (x, y, 1) of camera C.
struct RayObservation {
  Pose X_WC;
  Eigen::Vector2d xy;  ///< Normalised image coordinates (undistorted, focal length 1).
};

/// Least squares over reprojection errors in normalised coordinates: Gauss-Newton from the point nearest to all rays
/// (Hartley and Zisserman 2003, section 12.2, as least squares over ray distances).
/// @returns nothing if the rays are nearly parallel or the point lies behind a camera.
std::optional<Eigen::Vector3d> TriangulatePoint(const std::vector<RayObservation>& observations);

/// The maximum angle at the point between two of its rays, rad.
double ParallaxAngle(const Eigen::Vector3d& p_W, const std::vector<RayObservation>& observations);

/// Distance of observation and projection, in normalised coordinates; infinity behind the camera.
double ReprojectionError(const Eigen::Vector3d& p_W, const RayObservation& observation);

}  // namespace gaitcam
