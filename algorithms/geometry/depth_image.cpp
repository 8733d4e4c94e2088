#include "algorithms/geometry/depth_image.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace gaitcam {

std::optional<double> DepthAt(const cv::Mat& depth, const Eigen::Vector2d& pixel) {
  const int x = int(std::floor(pixel.x())), y = int(std::floor(pixel.y()));
  if (x < 0 || y < 0 || x + 1 >= depth.cols || y + 1 >= depth.rows) return std::nullopt;
  const double a = pixel.x() - x, b = pixel.y() - y;
  double inverse = 0, nearest = HUGE_VAL, farthest = 0;
  for (const auto& [dx, dy, w] : {std::tuple{0, 0, (1 - a) * (1 - b)}, std::tuple{1, 0, a * (1 - b)},
                                  std::tuple{0, 1, (1 - a) * b}, std::tuple{1, 1, a * b}}) {
    const double z = double(depth.at<float>(y + dy, x + dx));
    if (!(z > 0)) return std::nullopt;
    inverse += w / z;
    nearest = std::min(nearest, z);
    farthest = std::max(farthest, z);
  }
  if (farthest > 1.05 * nearest) return std::nullopt;
  return 1 / inverse;
}

}  // namespace gaitcam
