/// Points held as a ray of the camera that saw them first and their inverse depth along it (Civera, Davison and
/// Montiel, TRO 2008): a point of unknown depth, or at infinity, is as good a constraint on rotation as any other, and
/// its error is nearly Gaussian in this form.
///
/// A point anchored in camera A lies at (x, y, 1) / rho in A's frame. Seen from camera C its direction is
///   h = R_C^T (R_A (x, y, 1)^T + rho (t_A - t_C)),                                                              (1)
/// which holds for rho = 0 too. All coordinates are normalised (undistorted, focal length 1).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

/// A point as it is known.
struct InverseDepthPoint {
  Pose X_WA;                                     ///< The camera that saw it first ...
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< ... and where it saw it.
  double xy_sigma = 0;                           ///< Standard deviation of each coordinate of `xy`.
  double rho = 0;                                ///< Inverse depth, 1 over the world's unit.
  double rho_sigma = 0;                          ///< Standard deviation of it.
};

/// Where a point is seen, and how exactly.
struct InverseDepthSighting {
  InverseDepthPoint point;
  Eigen::Vector2d xy;  ///< Measured.
  double sigma = 0;    ///< Standard deviation of each coordinate.
};

/// Equation 1 and what it depends on. Turns are right perturbations: R exp([w]x).
struct InverseDepthProjection {
  Eigen::Vector2d xy;
  Eigen::Matrix<double, 2, 6> d_anchor;  ///< d xy / d (w_A, t_A)
  Eigen::Matrix<double, 2, 6> d_camera;  ///< d xy / d (w_C, t_C)
  Eigen::Matrix2d d_xy;                  ///< By the ray in the anchor.
  Eigen::Vector2d d_rho;
};

/// @returns where camera C sees the point, or nothing if it lies behind.
std::optional<Eigen::Vector2d> ProjectInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                   const Pose& X_WC);

/// The same with its derivatives.
std::optional<InverseDepthProjection> LinearizeInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                            const Pose& X_WC);

/// Squared distance between measurement and projection in standard deviations, the point's own uncertainty counted in:
/// covariance (sigma^2 + xy_sigma^2) I + d_rho rho_sigma^2 d_rho^T, the two cameras' scales being about the same.
/// Chi-square with 2 degrees of freedom for true pairs; infinity for a point behind the camera.
double Mahalanobis2(const InverseDepthSighting& sighting, const Pose& X_WC);

/// Maximum likelihood of the camera's pose by Gauss-Newton, Huber's weights beyond `huber` standard deviations. Depths
/// that are not known constrain the turn alone.
/// @param use indices into `sightings`
/// @returns the pose, or `X_WC` itself where the problem is singular. Never NaN.
Pose RefinePose(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                double huber);

}  // namespace gaitcam
