#include "models/picture_textures.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "models/texture_noise.h"
#include "models/texture_paint.h"

namespace gaitcam {
namespace {

/// A random colour around `rgb`: brightness varies most, as in photographs.
cv::Scalar LeafColor(const TextureOptions& o, RandomStream& random) {
  const double brightness = random.Uniform(-0.45, 0.45);
  Eigen::Vector3d color = o.rgb;
  for (int c = 0; c < 3; ++c) color[c] += o.contrast * (brightness + random.Normal(0, 0.09));
  return Bgr(color.cwiseMax(0.02).cwiseMin(0.98));
}

}  // namespace

cv::Mat MakeDeadLeaves(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3, Bgr(o.rgb));
  constexpr double kMinRadius = 1.5, kCover = 6;  // px; how many leaves lie over a point on average
  const double max_radius = std::max(2 * kMinRadius, o.unit_m * o.px_per_m);
  const double a = 1 / (kMinRadius * kMinRadius), b = 1 / (max_radius * max_radius);
  const double mean_area = 2 * M_PI * std::log(max_radius / kMinRadius) / (a - b);
  const double reach_x = size.width + 2 * max_radius, reach_y = size.height + 2 * max_radius;
  const int count = int(kCover * reach_x * reach_y / mean_area);
  constexpr int kShift = 4;
  for (int i = 0; i < count; ++i) {
    const double radius = 1 / std::sqrt(a - (a - b) * random.Uniform());  // inverse of the distribution of r^-3
    const cv::Point2d at(random.Uniform(0, reach_x) - max_radius, random.Uniform(0, reach_y) - max_radius);
    const cv::Scalar color = LeafColor(o, random);
    if (at.x < -radius || at.y < -radius || at.x > size.width + radius || at.y > size.height + radius) continue;
    cv::circle(bgr, {int(at.x * (1 << kShift)), int(at.y * (1 << kShift))}, int(radius * (1 << kShift)), color,
               cv::FILLED, cv::LINE_AA, kShift);
  }
  return bgr;
}

}  // namespace gaitcam
