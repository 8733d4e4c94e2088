/// Where a plane's pixels move between two images, thesis 6.4.1, Eqs. 6.3 to 6.16.
///
/// Frames: R is the camera at the reference image, C at the current one. A point p of the plane (in R) satisfies
/// n_d . p = 1, n_d being the plane's normal over its distance; it is seen in C at X_CR p, which makes the homography
/// H = R + t n_d' of Eq. 6.3 between normalised coordinates. n_d is carried by the inverse depths of three image points
/// and their logarithms (Eqs. 6.12 to 6.16), which keeps the plane in front of the camera.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/se3.h"

namespace gaitcam {

/// How two images of a plane are related.
struct PlaneState {
  Pose X_CR;                                            ///< T of Eq. 6.6.
  Eigen::Vector3d normal_d = Eigen::Vector3d(0, 0, 1);  ///< n_d of Eq. 6.3, in R, 1/m.
  double gain = 1, offset = 0;                          ///< current = gain reference + offset.
};

/// Where a pixel of R is seen in C (Eq. 6.7), px; nothing if it falls behind the camera.
std::optional<Eigen::Vector2d> WarpPixel(const CameraModel& camera, const PlaneState& state,
                                         const Eigen::Vector2d& p_R);

namespace internal {

/// Pixel of a pyramid level whose pixels are `scale` = 2^level wide, from a point in the camera's frame, and back to a
/// ray of depth 1.
inline Eigen::Vector2d ToPixel(const CameraModel& camera, double scale, const Eigen::Vector3d& p) {
  return {(camera.fx * p.x() / p.z() + camera.cx) / scale, (camera.fy * p.y() / p.z() + camera.cy) / scale};
}

inline Eigen::Vector3d ToRay(const CameraModel& camera, double scale, const Eigen::Vector2d& p) {
  return {(scale * p.x() - camera.cx) / camera.fx, (scale * p.y() - camera.cy) / camera.fy, 1};
}

/// Derivative of the pixel by the point in the camera's frame.
inline Eigen::Matrix<double, 2, 3> PixelJacobian(const CameraModel& camera, double scale, const Eigen::Vector3d& p) {
  const double fx = camera.fx / scale, fy = camera.fy / scale, iz = 1 / p.z();
  Eigen::Matrix<double, 2, 3> J;
  J << fx * iz, 0, -fx * p.x() * iz * iz, 0, fy * iz, -fy * p.y() * iz * iz;
  return J;
}

/// M of Eq. 6.15 for normalised coordinates of three points: n_d = M z. Columns: the points' share.
Eigen::Matrix3d NormalFromInverseDepths(const std::vector<Eigen::Vector3d>& rays);

/// Derivative of the warped pixel (in C, px) by tau of X_CR Exp(tau) and by the log inverse depths, at zero increments.
/// @param scale 2^level.
Eigen::Matrix<double, 2, 9> WarpJacobian(const CameraModel& camera, double scale, const PlaneState& state,
                                         const Eigen::Matrix3d& M, const Eigen::Vector2d& p_R);

}  // namespace internal
}  // namespace gaitcam
