/// A point's image in one of a rig's two cameras, and how it moves with all that it depends on.

#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "algorithms/core/pose.h"
#include "algorithms/core/se3.h"

namespace gaitcam {

constexpr double kLeastDepth = 1e-3;  ///< m. A point nearer than this to a camera's plane has no image.

struct RigProjection {
  Eigen::Vector2d xy;                     ///< Normalised coordinates.
  Eigen::Matrix<double, 2, 6> by_camera;  ///< Derivatives by the tangent of X_WC ...
  Eigen::Matrix<double, 2, 6> by_rig;     ///< ... of X_LR; zero in the left camera ...
  Eigen::Matrix<double, 2, 3> by_point;   ///< ... and by p_W.
};

/// @param X_RL the right camera's, or null for the image in the left one.
/// @returns nothing for a point behind the camera.
inline std::optional<RigProjection> ProjectInRig(const Pose& X_CW, const Pose* X_RL, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = X_CW * p_W;
  const Eigen::Vector3d p = X_RL != nullptr ? *X_RL * p_C : p_C;
  if (p.z() <= kLeastDepth) return {};
  const double inverse = 1 / p.z();
  Eigen::Matrix<double, 2, 3> d_xy;
  d_xy << inverse, 0, -p.x() * inverse * inverse, 0, inverse, -p.y() * inverse * inverse;
  RigProjection projection;
  projection.xy = inverse * p.head<2>();
  projection.by_rig.setZero();
  if (X_RL != nullptr) {
    projection.by_rig << -d_xy, d_xy * Hat(p);
    d_xy = (d_xy * X_RL->R()).eval();
  }
  projection.by_camera << -d_xy, d_xy * Hat(p_C);
  projection.by_point = d_xy * X_CW.R();
  return projection;
}

/// W with W' W = covariance^-1: it makes residuals of their own standard deviations.
template <int N>
Eigen::Matrix<double, N, N> Whitening(const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> factors(covariance);
  return factors.matrixL().solve(Eigen::Matrix<double, N, N>::Identity());
}

}  // namespace gaitcam
