#include "algorithms/odometry/keypoint_noise.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace gaitcam {

namespace {

/// Where the image of a point was against mid-exposure, at each instant at which it is seen.
std::vector<Eigen::Vector2d> LightPath(const CameraModel& camera, const std::vector<Pose>& path,
                                       const Eigen::Vector2d& pixel, double inverse_depth) {
  const Eigen::Vector3d ray = camera.Unproject(pixel);
  std::vector<Eigen::Vector2d> light;
  for (const Pose& X_TM : path) {
    if (const auto at = camera.Project(X_TM.rotation * ray + inverse_depth * X_TM.translation)) {
      light.push_back(*at - pixel);
    }
  }
  return light;
}

/// Of each coordinate, px^2: what a sharp image leaves.
double SharpVariance(const cv::KeyPoint& keypoint, const KeypointNoiseOptions& o) {
  return std::pow(o.sigma_px, 2) + std::pow(o.sigma_per_size * double(keypoint.size), 2);
}

}  // namespace

Eigen::Matrix2d BlurSpread(const CameraModel& camera, const std::vector<Pose>& path, const Eigen::Vector2d& pixel,
                           double inverse_depth) {
  const std::vector<Eigen::Vector2d> light = LightPath(camera, path, pixel, inverse_depth);
  if (light.empty()) return Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& at : light) mean += at / double(light.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& at : light) spread += (at - mean) * (at - mean).transpose() / double(light.size());
  return spread;
}

Eigen::Vector2d RowOffset(const CameraModel& camera, const std::vector<Pose>& readout, const Eigen::Vector2d& seen,
                          double inverse_depth) {
  if (readout.size() < 2) return Eigen::Vector2d::Zero();
  const size_t intervals = readout.size() - 1;
  const double at = std::clamp(seen.y() / std::max(1.0, camera.height_px - 1.0), 0.0, 1.0) * double(intervals);
  const size_t before = std::min(size_t(at), intervals - 1);
  const std::vector<Pose> around = {readout[before], readout[before + 1]};
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  constexpr int kIterations = 2;  // where it was at the stamp is not known before
  for (int i = 0; i < kIterations; ++i) {
    const std::vector<Eigen::Vector2d> light = LightPath(camera, around, seen - offset, inverse_depth);
    if (light.size() < 2) return Eigen::Vector2d::Zero();
    offset = light[0] + (at - double(before)) * (light[1] - light[0]);
  }
  return offset;
}

Eigen::Vector2d BlurOffset(const CameraModel& camera, const std::vector<Pose>& path, const Eigen::Vector2d& pixel,
                           double inverse_depth, double sigma_px) {
  const std::vector<Eigen::Vector2d> light = LightPath(camera, path, pixel, inverse_depth);
  if (light.empty()) return Eigen::Vector2d::Zero();
  const auto weight = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& x) {
    return std::exp(-0.5 * (at - x).squaredNorm() / (sigma_px * sigma_px));
  };
  const auto density = [&](const Eigen::Vector2d& x) {
    double sum = 0;
    for (const Eigen::Vector2d& at : light) sum += weight(at, x);
    return sum;
  };
  Eigen::Vector2d x = light.front();
  for (const Eigen::Vector2d& at : light) {
    if (density(at) > density(x)) x = at;
  }
  constexpr int kShifts = 10;  // of the mean (D. Comaniciu and P. Meer, "Mean shift", 2002)
  for (int i = 0; i < kShifts; ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& at : light) sum += weight(at, x) * at;
    x = sum / density(x);
  }
  return x;
}

double ImageNoise(const cv::Mat& grey) {
  if (grey.rows < 3 || grey.cols < 3) return 0;
  const cv::Matx33f kernel(1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat difference;
  cv::filter2D(grey, difference, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101);
  const double mean = cv::norm(difference, cv::NORM_L1) / double(grey.total());
  return std::sqrt(std::numbers::pi / 2) * mean / 6;  // 6: the kernel's root sum of squares
}

Eigen::Matrix2d NoiseBound(const cv::Mat& grey, const cv::KeyPoint& keypoint, double noise) {
  if (!(noise > 0)) return Eigen::Matrix2d::Zero();
  constexpr double kGradientNoise = 0.5;   // variance of a central difference, in that of a pixel
  constexpr double kLeastGradient = 0.05;  // mean squared gradient, in the noise's variance
  const int radius = std::max(1, int(std::lround(0.5 * double(keypoint.size))));
  const int x0 = int(std::lround(keypoint.pt.x)), y0 = int(std::lround(keypoint.pt.y));
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  int pixels = 0;
  for (int y = std::max(1, y0 - radius); y <= std::min(grey.rows - 2, y0 + radius); ++y) {
    for (int x = std::max(1, x0 - radius); x <= std::min(grey.cols - 2, x0 + radius); ++x) {
      const Eigen::Vector2d gradient(0.5 * (grey.at<uint8_t>(y, x + 1) - grey.at<uint8_t>(y, x - 1)),
                                     0.5 * (grey.at<uint8_t>(y + 1, x) - grey.at<uint8_t>(y - 1, x)));
      sum += gradient * gradient.transpose();
      ++pixels;
    }
  }
  const double variance = noise * noise, area = std::max(1, pixels);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(sum);
  const Eigen::Vector2d information =
      (axes.eigenvalues().array() - kGradientNoise * variance * area).cwiseMax(kLeastGradient * variance * area);
  return variance * axes.eigenvectors() * information.cwiseInverse().asDiagonal() * axes.eigenvectors().transpose();
}

double PointsPerError(const std::vector<cv::KeyPoint>& keypoints, const std::vector<Eigen::Matrix2d>& covariances_px,
                      const KeypointNoiseOptions& o) {
  double sharp_share = 0;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    sharp_share += SharpVariance(keypoints[i], o) / (0.5 * covariances_px[i].trace()) / double(keypoints.size());
  }
  return o.points_per_blur_error + std::min(1.0, sharp_share) * (o.points_per_error - o.points_per_blur_error);
}

Eigen::Matrix2d KeypointCovariance(const cv::KeyPoint& keypoint, const Eigen::Matrix2d& spread,
                                   const Eigen::Matrix2d& bound, const KeypointNoiseOptions& o) {
  constexpr double kExtent2PerSpread = 12;
  const double across = kExtent2PerSpread * std::pow(o.sigma_across_blur, 2);
  const double along = kExtent2PerSpread * std::pow(o.sigma_per_blur, 2) - across;
  const double isotropic = SharpVariance(keypoint, o) + across * spread.trace();
  return isotropic * Eigen::Matrix2d::Identity() + along * spread + std::pow(o.sigma_per_noise, 2) * bound;
}

}  // namespace gaitcam
