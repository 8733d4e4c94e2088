#include "algorithms/core/camera.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {

CameraModel CameraModel::FromHorizontalFov(int width_px, int height_px, double hfov_deg) {
  CameraModel camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx = camera.fy = 0.5 * width_px / std::tan(0.5 * hfov_deg * std::numbers::pi / 180);
  camera.cx = 0.5 * (width_px - 1);
  camera.cy = 0.5 * (height_px - 1);
  return camera;
}

bool CameraModel::IsDistorted() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }

Eigen::Vector2d CameraModel::Distort(const Eigen::Vector2d& ideal) const {
  const double x = ideal.x(), y = ideal.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

Eigen::Matrix2d CameraModel::DistortionJacobian(const Eigen::Vector2d& ideal) const {
  const double x = ideal.x(), y = ideal.y(), r2 = ideal.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2 * (k1 + r2 * (2 * k2 + 3 * k3 * r2));  // d(radial)/dx = slope x, d(radial)/dy = slope y
  Eigen::Matrix2d J;
  J << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, slope * x * y + 2 * p1 * x + 2 * p2 * y,
      slope * x * y + 2 * p1 * x + 2 * p2 * y, radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
  return J;
}

std::optional<Eigen::Vector2d> CameraModel::Project(const Eigen::Vector3d& p_C) const {
  if (!(p_C.z() > 0)) return std::nullopt;
  const Eigen::Vector2d d = Distort({p_C.x() / p_C.z(), p_C.y() / p_C.z()});
  return Eigen::Vector2d(fx * d.x() + cx, fy * d.y() + cy);
}

Eigen::Vector3d CameraModel::Unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Eigen::Vector2d p = target;
  if (!IsDistorted()) return p.homogeneous();
  // Newton's method on Distort(p) = target with the analytic Jacobian.
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d step = DistortionJacobian(p).inverse() * (target - Distort(p));
    p += step;
    if (step.norm() < 1e-13) break;
  }
  return p.homogeneous();
}

bool CameraModel::Contains(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width_px - 0.5 && pixel.y() < height_px - 0.5;
}

Eigen::Matrix3d CameraModel::K() const {
  Eigen::Matrix3d K;
  K << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return K;
}

void CameraModel::Check() const {
  if (width_px <= 0 || height_px <= 0) {
    throw BadOption("camera: image size " + std::to_string(width_px) + " x " + std::to_string(height_px) +
                    " px is not positive");
  }
  if (!(fx > 0 && fy > 0)) {
    throw BadOption("camera: focal lengths fx = " + std::to_string(fx) + ", fy = " + std::to_string(fy) +
                    " px must be positive");
  }
}

}  // namespace gaitcam
