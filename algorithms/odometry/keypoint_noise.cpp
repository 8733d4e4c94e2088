#include "algorithms/odometry/keypoint_noise.h"

#include <cmath>

namespace gaitcam {

namespace {

/// Where the image of a point was against mid-exposure, at each instant at which it is seen.
std::vector<Eigen::Vector2d> LightPath(const CameraModel& camera, const std::vector<ExposureRotation>& rotations,
                                       const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = camera.Unproject(pixel);
  std::vector<Eigen::Vector2d> path;
  for (const ExposureRotation& r : rotations) {
    if (const auto at = camera.Project(r.rotation * ray)) path.push_back(*at - pixel);
  }
  return path;
}

}  // namespace

Eigen::Matrix2d BlurSpread(const CameraModel& camera, const std::vector<ExposureRotation>& rotations,
                           const Eigen::Vector2d& pixel) {
  const std::vector<Eigen::Vector2d> path = LightPath(camera, rotations, pixel);
  if (path.empty()) return Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& at : path) mean += at / double(path.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& at : path) spread += (at - mean) * (at - mean).transpose() / double(path.size());
  return spread;
}

Eigen::Vector2d BlurOffset(const CameraModel& camera, const std::vector<ExposureRotation>& rotations,
                           const Eigen::Vector2d& pixel, double sigma_px) {
  const std::vector<Eigen::Vector2d> path = LightPath(camera, rotations, pixel);
  if (path.empty()) return Eigen::Vector2d::Zero();
  const auto weight = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& x) {
    return std::exp(-0.5 * (at - x).squaredNorm() / (sigma_px * sigma_px));
  };
  const auto density = [&](const Eigen::Vector2d& x) {
    double sum = 0;
    for (const Eigen::Vector2d& at : path) sum += weight(at, x);
    return sum;
  };
  Eigen::Vector2d x = path.front();
  for (const Eigen::Vector2d& at : path) {
    if (density(at) > density(x)) x = at;
  }
  constexpr int kShifts = 10;  // of the mean (D. Comaniciu and P. Meer, "Mean shift", 2002)
  for (int i = 0; i < kShifts; ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& at : path) sum += weight(at, x) * at;
    x = sum / density(x);
  }
  return x;
}

Eigen::Matrix2d KeypointCovariance(const cv::KeyPoint& keypoint, const Eigen::Matrix2d& spread,
                                   const KeypointNoiseOptions& o) {
  constexpr double kExtent2PerSpread = 12;
  const double across = kExtent2PerSpread * std::pow(o.sigma_across_blur, 2);
  const double along = kExtent2PerSpread * std::pow(o.sigma_per_blur, 2) - across;
  const double isotropic =
      std::pow(o.sigma_px, 2) + std::pow(o.sigma_per_size * keypoint.size, 2) + across * spread.trace();
  return isotropic * Eigen::Matrix2d::Identity() + along * spread;
}

}  // namespace gaitcam
