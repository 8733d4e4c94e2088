#include "algorithms/odometry/keypoint_noise.h"

#include <cmath>

namespace gaitcam {

Eigen::Matrix2d BlurSpread(const CameraModel& camera, const std::vector<ExposureRotation>& rotations,
                           const Eigen::Vector2d& pixel) {
  if (rotations.empty()) return Eigen::Matrix2d::Zero();
  const Eigen::Vector3d ray = camera.Unproject(pixel);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0;
  for (const ExposureRotation& r : rotations) {
    const auto at = camera.Project(r.rotation * ray);
    if (!at) continue;
    const Eigen::Vector2d offset = *at - pixel;
    sum += offset;
    squares += offset * offset.transpose();
    ++count;
  }
  if (count == 0) return Eigen::Matrix2d::Zero();
  return squares / count - sum * sum.transpose() / (count * count);
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
