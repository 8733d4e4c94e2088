#include "models/code/scenes/footprint.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace gaitcam {

std::vector<cv::Point2f> Footprint(const SceneBox& box, double high_m) {
  constexpr double kFlat_m = 0.01;
  std::vector<cv::Point2f> corners, hull;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    const Eigen::Vector3d corner = box.X_WB * Eigen::Vector3d(sign.cwiseProduct(box.size));
    corners.emplace_back(float(corner.x()), float(corner.y()));
    low = std::min(low, corner.z());
    high = std::max(high, corner.z());
  }
  if (!box.collides || high < kFlat_m || low > high_m) return {};
  cv::convexHull(corners, hull);
  return hull;
}

}  // namespace gaitcam
