#include "scenarios/code/datasets/floor_intrinsics.h"

#include <cmath>

#include "algorithms/core/median.h"
#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

constexpr int kStep_px = 4;        // between samples
constexpr double kMaxDepth_m = 4;  // beyond it the depth's resolution is too coarse
constexpr double kFirstWindow_m = 0.03, kWindow_m = 0.002;
constexpr size_t kMin = 200;

}  // namespace

void FloorFit::Add(const Pose& X_WC, const cv::Mat& depth) {
  const Eigen::RowVector3d r = X_WC.R().row(2);
  for (int v = kStep_px / 2; v < depth.rows; v += kStep_px) {
    for (int u = kStep_px / 2; u < depth.cols; u += kStep_px) {
      const double z = double(depth.at<float>(v, u));
      if (!(z > 0 && z < kMaxDepth_m)) continue;
      const Eigen::Vector3d ray = camera_.Unproject({double(u), double(v)});
      const Sample s{ray.x(), ray.y(), z, r[0], r[1], r[2], X_WC.translation.z()};
      if (std::abs(s.t_z + z * r.dot(ray)) < kFirstWindow_m) samples_.push_back(s);
    }
  }
}

std::optional<FloorIntrinsics> FloorFit::Fit() const {
  Eigen::Vector4d c(1, 0, 1, 0);  // s_x, o_x, s_y, o_y
  Eigen::Matrix4d normal;
  double window = kFirstWindow_m, sum = 0;
  size_t count = 0;
  for (const double next_window : {4 * kWindow_m, kWindow_m, kWindow_m}) {
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    normal.setZero();
    count = 0;
    sum = 0;
    for (const Sample& s : samples_) {
      const Eigen::Vector4d row = s.depth * Eigen::Vector4d(s.r0 * s.x, s.r0, s.r1 * s.y, s.r1);
      const double offset = s.t_z + s.depth * s.r2, height = row.dot(c) + offset;
      if (std::abs(height) > window) continue;
      normal += row * row.transpose();
      right -= row * offset;
      sum += height * height;
      ++count;
    }
    if (count < kMin) return std::nullopt;
    c = SolveSymmetric(normal, right);
    window = next_window;
  }
  const double variance = sum / double(count);
  const Eigen::Matrix4d covariance = variance * InverseOfSymmetric(normal);
  FloorIntrinsics fit;
  fit.fx = camera_.fx / c[0];
  fit.fy = camera_.fy / c[2];
  fit.fx_std = fit.fx * std::sqrt(covariance(0, 0)) / c[0];
  fit.fy_std = fit.fy * std::sqrt(covariance(2, 2)) / c[2];
  fit.rms_m = std::sqrt(variance);
  fit.points = int(count);
  if (!std::isfinite(fit.fx_std) || !std::isfinite(fit.fy_std) || !(c[0] > 0 && c[2] > 0)) return std::nullopt;
  return fit;
}

std::optional<double> FloorFit::FloorHeight(const CameraModel& camera, const Pose& X_WC, const cv::Mat& depth) {
  FloorFit fit(camera);
  fit.Add(X_WC, depth);
  if (fit.samples_.size() < kMin) return std::nullopt;
  std::vector<double> heights;
  for (const Sample& s : fit.samples_) heights.push_back(std::abs(s.t_z + s.depth * (s.r0 * s.x + s.r1 * s.y + s.r2)));
  return UpperMedian(std::move(heights));
}

}  // namespace gaitcam
