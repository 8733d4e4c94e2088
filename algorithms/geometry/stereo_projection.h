/// What the two cameras of a rig show of a point, without their lenses' distortion.

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// A sighting in ideal pixels: what the same cameras would show without distortion.
struct IdealSighting {
  Eigen::Vector4d u;                    ///< u, v, u', v', px.
  Eigen::Vector3d ray_left, ray_right;  ///< Unit, both in the left camera's frame.
  Eigen::Matrix4d derivative;           ///< Of u by the filmed pixels.
  Eigen::Matrix4d covariance;           ///< Of u, px^2.
  Eigen::Matrix4d whiten;               ///< whiten^T whiten is its inverse.

  /// Nothing if a pixel is not finite, or no ray reaches it through the lens.
  static std::optional<IdealSighting> Of(const StereoRig& rig, const StereoSighting& sighting);
};

/// Its u alone.
std::optional<Eigen::Vector4d> IdealPixels(const StereoRig& rig, const Eigen::Vector2d& left,
                                           const Eigen::Vector2d& right);

/// What four ideal pixels are, given q = (x/z, y/z, 1/z) of a point in the left camera's frame, and their derivatives
/// by q. In these coordinates both images are nearly linear, also for points that are far; q_z = 0 is at infinity.
struct StereoProjection {
  Eigen::Vector4d u;
  Eigen::Matrix<double, 4, 3> J;
  std::array<Eigen::Matrix3d, 4> hessians;

  StereoProjection(const StereoRig& rig, const Eigen::Vector3d& q);
};

}  // namespace gaitcam
