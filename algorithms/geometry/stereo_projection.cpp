#include "algorithms/geometry/stereo_projection.h"

#include <Eigen/LU>
#include <cmath>

namespace gaitcam {
namespace {

/// A pixel as the camera would show it without distortion.
struct IdealPixel {
  Eigen::Vector2d xy;          ///< Of the ray (x, y, 1).
  Eigen::Vector2d pixel;       ///< The same in pixels.
  Eigen::Matrix2d derivative;  ///< d pixel / d filmed pixel.
};

std::optional<IdealPixel> Undistorted(const CameraModel& camera, const Eigen::Vector2d& filmed) {
  if (!filmed.allFinite()) return std::nullopt;
  IdealPixel ideal;
  ideal.xy = camera.Unproject(filmed).head<2>();
  const Eigen::Vector2d f(camera.fx, camera.fy), c(camera.cx, camera.cy);
  // Beyond the fold of a strong distortion Newton's method does not arrive, or does on its far side, where the image is
  // mirrored.
  constexpr double kArrived_px = 1e-6;
  const Eigen::Matrix2d J = camera.DistortionJacobian(ideal.xy);
  if (!ideal.xy.allFinite() || !(J.determinant() > 0 && J.trace() > 0) ||
      (camera.Distort(ideal.xy).cwiseProduct(f) + c - filmed).cwiseAbs().maxCoeff() > kArrived_px)
    return std::nullopt;
  ideal.pixel = ideal.xy.cwiseProduct(f) + c;
  ideal.derivative = f.asDiagonal() * J.inverse() * f.cwiseInverse().asDiagonal();
  return ideal;
}

/// L^-1 of S = L L^T.
Eigen::Matrix2d Whitening(const Eigen::Matrix2d& S) {
  const double a = std::sqrt(S(0, 0)), b = S(1, 0) / a, c = std::sqrt(S(1, 1) - b * b);
  Eigen::Matrix2d inverse;
  inverse << 1 / a, 0, -b / (a * c), 1 / c;
  return inverse;
}

}  // namespace

std::optional<Eigen::Vector4d> IdealPixels(const StereoRig& rig, const Eigen::Vector2d& left,
                                           const Eigen::Vector2d& right) {
  const auto l = Undistorted(rig.left, left), r = Undistorted(rig.right, right);
  if (!l || !r) return std::nullopt;
  return (Eigen::Vector4d() << l->pixel, r->pixel).finished();
}

std::optional<IdealSighting> IdealSighting::Of(const StereoRig& rig, const StereoSighting& sighting) {
  const auto left = Undistorted(rig.left, sighting.left), right = Undistorted(rig.right, sighting.right);
  if (!left || !right) return std::nullopt;
  IdealSighting ideal;
  ideal.u << left->pixel, right->pixel;
  ideal.ray_left = left->xy.homogeneous().normalized();
  ideal.ray_right = rig.X_LR.rotation * right->xy.homogeneous().normalized();
  ideal.derivative.setZero();
  ideal.covariance.setZero();
  ideal.whiten.setZero();
  for (int k = 0; k < 2; ++k) {
    const Eigen::Matrix2d& D = k == 0 ? left->derivative : right->derivative;
    const Eigen::Matrix2d S = D * (k == 0 ? sighting.covariance_left : sighting.covariance_right) * D.transpose();
    ideal.derivative.block<2, 2>(2 * k, 2 * k) = D;
    ideal.covariance.block<2, 2>(2 * k, 2 * k) = S;
    ideal.whiten.block<2, 2>(2 * k, 2 * k) = Whitening(S);
  }
  return ideal;
}

StereoProjection::StereoProjection(const StereoRig& rig, const Eigen::Vector3d& q) {
  const Pose X_RL = rig.X_LR.Inverse();
  const Eigen::Matrix3d R = X_RL.R();
  Eigen::Matrix3d M;  // the point in the right camera, over its depth in the left one, is M q + R's last column
  M << R.col(0), R.col(1), X_RL.translation;
  const Eigen::Vector3d h = M * q + R.col(2);
  const CameraModel &left = rig.left, &right = rig.right;
  u << left.fx * q.x() + left.cx, left.fy * q.y() + left.cy, right.fx * h.x() / h.z() + right.cx,
      right.fy * h.y() / h.z() + right.cy;
  J.topRows<2>() << left.fx, 0, 0, 0, left.fy, 0;
  hessians[0] = hessians[1] = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 2; ++k) {
    const double f = k == 0 ? right.fx : right.fy;
    Eigen::RowVector3d gradient = Eigen::RowVector3d::Zero();  // of h_k / h_z by h
    gradient[k] = 1 / h.z();
    gradient[2] = -h[k] / (h.z() * h.z());
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    hessian(k, 2) = hessian(2, k) = -1 / (h.z() * h.z());
    hessian(2, 2) = 2 * h[k] / (h.z() * h.z() * h.z());
    J.row(2 + k) = f * gradient * M;
    hessians[size_t(2 + k)] = f * M.transpose() * hessian * M;
  }
}

}  // namespace gaitcam
