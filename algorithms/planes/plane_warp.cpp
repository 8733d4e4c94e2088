#include "algorithms/planes/plane_warp.h"

#include <Eigen/LU>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace internal {

Eigen::Matrix3d NormalFromInverseDepths(const std::vector<Eigen::Vector3d>& rays) {
  GAITCAM_ASSERT(rays.size() == 3);
  Eigen::Matrix3d stacked;  // Eq. 6.13: rays' n_d = z
  for (int i = 0; i < 3; ++i) stacked.row(i) = rays[size_t(i)].transpose();
  return stacked.inverse();
}

Eigen::Matrix<double, 2, 9> WarpJacobian(const CameraModel& camera, double scale, const PlaneState& state,
                                         const Eigen::Matrix3d& M, const Eigen::Vector2d& p_R) {
  const Eigen::Vector3d ray = ToRay(camera, scale, p_R);
  const double rho = state.normal_d.dot(ray);
  const Eigen::Matrix3d R = state.X_CR.R();
  const Eigen::Vector3d z = M.inverse() * state.normal_d;
  Eigen::Matrix<double, 3, 9> J;
  J.leftCols<3>() = rho * R;
  J.middleCols<3>(3) = -R * Hat(ray);
  J.rightCols<3>() = state.X_CR.translation * (ray.transpose() * M * z.asDiagonal());
  return PixelJacobian(camera, scale, R * ray + rho * state.X_CR.translation) * J;
}

}  // namespace internal

std::optional<Eigen::Vector2d> WarpPixel(const CameraModel& camera, const PlaneState& state,
                                         const Eigen::Vector2d& p_R) {
  const Eigen::Vector3d ray = internal::ToRay(camera, 1, p_R);
  const Eigen::Vector3d p = state.X_CR.R() * ray + state.normal_d.dot(ray) * state.X_CR.translation;
  if (p.z() <= 0) return std::nullopt;
  return internal::ToPixel(camera, 1, p);
}

}  // namespace gaitcam
