#include "algorithms/planes/plane_residuals.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace gaitcam {

using internal::ToPixel;
using internal::ToRay;

BlurMotion CurrentBlur::Motion(const Pose& X_CR) const {
  if (ratio == 0) return BlurMotion::Zero();
  BlurMotion motion = ratio * LogSe3(X_CR * X_RP);
  if (turn) motion.tail<3>() = -*turn;
  return motion;
}

PlaneResiduals::PlaneResiduals(const CameraModel& camera, int max_blur_samples, const PlaneReference& reference,
                               const ImagePyramid& current, size_t k, const CurrentBlur& blur)
    : camera_(camera),
      max_blur_samples_(max_blur_samples),
      reference_(reference.pyramid.levels[k]),
      current_(current.levels[k]),
      points_(reference.points[k]),
      reference_blur_(reference.blur),
      blur_(blur),
      scale_(double(1 << k)),
      fx_(camera.fx / scale_),
      fy_(camera.fy / scale_) {
  for (int samples = 1; samples <= max_blur_samples; ++samples) {
    for (int i = 0; i < samples; ++i) offsets_.push_back((i + 0.5) / samples - 0.5);
  }
  rays_.reserve(points_.size());
  for (const Eigen::Vector2d& p : points_) rays_.push_back(ToRay(camera, scale_, p));
  const double w = camera.width_px - 1, h = camera.height_px - 1;
  const std::vector<Eigen::Vector3d> corners{ToRay(camera, 1, {0, h}), ToRay(camera, 1, {w, h}),
                                             ToRay(camera, 1, {w / 2, h / 2})};
  M_ = internal::NormalFromInverseDepths(corners);
  M_inverse_ = M_.inverse();
}

Eigen::Vector2d PlaneResiduals::Path(const Eigen::Vector3d& p, const BlurMotion& motion) const {
  const Eigen::Vector3d displacement = motion.head<3>() + motion.tail<3>().cross(p);
  return PixelJacobian(p) * displacement;
}

/// As internal::PixelJacobian has it.
Eigen::Matrix<double, 2, 3> PlaneResiduals::PixelJacobian(const Eigen::Vector3d& p) const {
  const double iz = 1 / p.z();
  Eigen::Matrix<double, 2, 3> J;
  J << fx_ * iz, 0, -fx_ * p.x() * iz * iz, 0, fy_ * iz, -fy_ * p.y() * iz * iz;
  return J;
}

/// Mean along an exposure's path, with about one sample a pixel.
std::optional<ImageSample> PlaneResiduals::Average(const PyramidLevel& level, const Eigen::Vector2d& p,
                                                   const Eigen::Vector2d& path) const {
  const double length = path.norm();
  const int wanted = length < 0.5 ? 1 : 1 + 2 * int(std::ceil((length - 0.5) / 2));
  const int samples = std::min(wanted, max_blur_samples_);
  if (samples == 1) {
    if (!level.Contains(p)) return std::nullopt;
    return level.At(p);
  }
  const Eigen::Vector2d half = 0.5 * path;
  if (!level.Contains(p - half) || !level.Contains(p + half)) return std::nullopt;
  cv::v_float32x4 sum = cv::v_setzero_f32();
  const double* const offsets = &offsets_[size_t(samples * (samples - 1) / 2)];
  for (int i = 0; i < samples; ++i) sum += level.LanesAt(p + offsets[i] * path);
  return PyramidLevel::SampleOf(sum * cv::v_setall_f32(1.0F / float(samples)));
}

PlaneResiduals::Shared PlaneResiduals::SharedOf(const PlaneState& state) const {
  Shared s;
  s.R = state.X_CR.R();
  s.t = state.X_CR.translation;
  s.n_d = state.normal_d;
  s.H = s.R + s.t * s.n_d.transpose();
  s.Mz = M_ * (M_inverse_ * s.n_d).asDiagonal();
  s.gain = state.gain;
  s.offset = state.offset;
  s.blur = blur_.Motion(state.X_CR);
  s.blurred = max_blur_samples_ > 1 && (!s.blur.isZero() || !reference_blur_.isZero());
  return s;
}

/// @param ray of the pixel p_R.
std::optional<PlaneResidual> PlaneResiduals::ResidualAt(const Shared& s, const Eigen::Vector2d& p_R,
                                                        const Eigen::Vector3d& ray) const {
  const double rho = s.n_d.dot(ray);
  if (rho <= 1e-6) return std::nullopt;  // on or above the horizon
  const Eigen::Vector3d p = s.H * ray;   // the point seen, times its inverse depth
  if (p.z() <= 1e-3) return std::nullopt;
  const Eigen::Matrix<double, 2, 3> dpixel = PixelJacobian(p);
  Eigen::Matrix2d A = dpixel * s.H.leftCols<2>();  // d p_C / d p_R
  A.col(0) *= scale_ / camera_.fx;
  A.col(1) *= scale_ / camera_.fy;
  if (std::abs(A.determinant()) < 1e-3) return std::nullopt;
  const Eigen::Matrix2d A_inverse = A.inverse();

  Eigen::Vector2d path_C = Eigen::Vector2d::Zero(), path_R = path_C;  // each in the other image
  if (s.blurred) {
    path_C = A_inverse * Path(p / rho, s.blur);
    path_R = A * Path(ray / rho, reference_blur_);
  }
  const std::optional<ImageSample> seen = Average(current_, ToPixel(camera_, scale_, p), path_R);
  const std::optional<ImageSample> expected = Average(reference_, p_R, path_C);
  if (!seen || !expected) return std::nullopt;

  PlaneResidual r;
  r.reference = expected->intensity;
  r.value = seen->intensity - (s.gain * r.reference + s.offset);
  // Eq. 6.19: with the mean of both images' gradients, by the current pixel, the step is of second order.
  const double e_u = s.gain * expected->du, e_v = s.gain * expected->dv;
  const double u = 0.5 * (seen->du + (e_u * A_inverse(0, 0) + e_v * A_inverse(1, 0)));
  const double v = 0.5 * (seen->dv + (e_u * A_inverse(0, 1) + e_v * A_inverse(1, 1)));
  const Eigen::RowVector3d by_point(u * dpixel(0, 0), v * dpixel(1, 1), u * dpixel(0, 2) + v * dpixel(1, 2));
  const Eigen::RowVector3d by_point_R = by_point * s.R;
  r.row.head<3>() = rho * by_point_R;
  r.row.segment<3>(3) = ray.cross(by_point_R.transpose()).transpose();
  r.row.tail<3>() = by_point.dot(s.t) * (ray.transpose() * s.Mz);
  return r;
}

std::vector<PlaneResidual> PlaneResiduals::At(const PlaneState& state) const {
  const Shared shared = SharedOf(state);
  std::vector<PlaneResidual> residuals;
  residuals.reserve(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    if (const auto residual = ResidualAt(shared, points_[i], rays_[i])) residuals.push_back(*residual);
  }
  return residuals;
}

double PlaneResiduals::Displacement_px(const PlaneState& state, const Eigen::Matrix<double, 9, 1>& step) const {
  constexpr size_t kEvery = 16;
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < points_.size(); i += kEvery, ++count) {
    sum += (internal::WarpJacobian(camera_, scale_, state, M_, points_[i]) * step).squaredNorm();
  }
  return count == 0 ? 0 : std::sqrt(sum / double(count));
}

}  // namespace gaitcam
