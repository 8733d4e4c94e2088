#include "algorithms/features/blur_path.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Complex = std::complex<float>;
using ComplexMatrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Points of light, each with its share of the exposure.
struct PathPoints {
  std::vector<Eigen::Vector2d> places;
  std::vector<double> shares;
};

/// At most `step_px` apart: middles of the pieces of each step of time.
PathPoints Scatter(const BlurPath& path, double step_px) {
  PathPoints points;
  const size_t steps = path.points.size() - 1;
  for (size_t i = 0; i < steps; ++i) {
    const Eigen::Vector2d &from = path.points[i], &to = path.points[i + 1];
    const int pieces = std::max(1, int(std::ceil((to - from).norm() / step_px)));
    for (int k = 0; k < pieces; ++k) {
      points.places.push_back(from + (k + 0.5) / pieces * (to - from));
      points.shares.push_back(1.0 / (double(steps) * pieces));
    }
  }
  return points;
}

/// exp(-2 pi i f p) for each frequency (row) and place (column).
ComplexMatrix Waves(const std::vector<double>& frequencies, const PathPoints& points, int axis) {
  ComplexMatrix waves(long(frequencies.size()), long(points.places.size()));
  for (long i = 0; i < waves.rows(); ++i)
    for (long k = 0; k < waves.cols(); ++k) {
      const double phase = -2 * M_PI * frequencies[size_t(i)] * points.places[size_t(k)][axis];
      waves(i, k) = Complex(float(std::cos(phase)), float(std::sin(phase)));
    }
  return waves;
}

}  // namespace

PlaneGain PathTransfer(const BlurPath& path, const cv::Size& plane) {
  std::vector<double> fx, fy;
  for (int x = 0; x <= plane.width / 2; ++x) fx.push_back(double(x) / plane.width);
  for (int y = 0; y < plane.height; ++y)
    fy.push_back(double(y <= plane.height / 2 ? y : y - plane.height) / plane.height);
  return PathTransfer(path, fx, fy);
}

PlaneGain PathTransfer(const BlurPath& path, const std::vector<double>& fx, const std::vector<double>& fy) {
  GAITCAM_ASSERT(!path.empty());
  constexpr double kStep_px = 0.5;  // what is lost of a piece's own extent: 0.1 in 1 at half a cycle per pixel
  PathPoints points = Scatter(path, kStep_px);
  // Neighbours closer than half a step are one: a path of many instants costs no more than a long one.
  PathPoints merged;
  for (size_t k = 0; k < points.places.size(); ++k) {
    if (!merged.places.empty() && (points.places[k] - merged.places.back()).norm() < 0.5 * kStep_px) {
      const double share = merged.shares.back() + points.shares[k];
      merged.places.back() += points.shares[k] / share * (points.places[k] - merged.places.back());
      merged.shares.back() = share;
    } else {
      merged.places.push_back(points.places[k]);
      merged.shares.push_back(points.shares[k]);
    }
  }
  ComplexMatrix down = Waves(fy, merged, 1);
  for (long k = 0; k < down.cols(); ++k) down.col(k) *= float(merged.shares[size_t(k)]);
  return (down * Waves(fx, merged, 0).transpose()).array();
}

BlurPath Resampled(const BlurPath& path, int count) {
  GAITCAM_ASSERT(!path.empty() && count >= 2);
  BlurPath out;
  const double steps = double(path.points.size() - 1);
  for (int i = 0; i < count; ++i) {
    const double place = steps * i / (count - 1);
    const size_t from = std::min(size_t(place), path.points.size() - 2);
    out.points.push_back(path.points[from] + (place - double(from)) * (path.points[from + 1] - path.points[from]));
  }
  return out;
}

namespace {

/// The largest distance of points of the same time.
double Difference(const BlurPath& a, const BlurPath& b) {
  double most = 0;
  for (size_t i = 0; i < std::min(a.points.size(), b.points.size()); ++i)
    most = std::max(most, (a.points[i] - b.points[i]).norm());
  return most;
}

Eigen::Vector2d Middle(const cv::Rect& part) {
  return {part.x + 0.5 * (part.width - 1), part.y + 0.5 * (part.height - 1)};
}

void DividePart(const PathAt& path_at, const cv::Rect& part, const PathDivisionOptions& options,
                std::vector<BlurRegion>& regions) {
  const BlurPath here = path_at(Middle(part));
  double across = 0, down = 0;
  for (const double sign : {-0.5, 0.5}) {
    across = std::max(across, Difference(here, path_at(Middle(part) + Eigen::Vector2d(sign * part.width, 0))));
    down = std::max(down, Difference(here, path_at(Middle(part) + Eigen::Vector2d(0, sign * part.height))));
  }
  const double tolerance = std::max(options.tolerance_px, options.tolerance_share * here.Length());
  const bool wide = across * part.width >= down * part.height;  // ties: the longer side
  const int side = wide ? part.width : part.height;
  if (std::max(across, down) <= tolerance || side < 2 * options.min_region_px) {
    regions.push_back({part, {here.Chord(), 1, here.Length() > 0}, here});
    return;
  }
  const int half = side / 2;
  cv::Rect first = part, second = part;
  if (wide) {
    first.width = half;
    second.x += half;
    second.width -= half;
  } else {
    first.height = half;
    second.y += half;
    second.height -= half;
  }
  DividePart(path_at, first, options, regions);
  DividePart(path_at, second, options, regions);
}

}  // namespace

std::vector<BlurRegion> DivideByPath(const PathAt& path_at, const cv::Size& image, const PathDivisionOptions& options) {
  GAITCAM_ASSERT(image.area() > 0);
  std::vector<BlurRegion> regions;
  DividePart(path_at, cv::Rect({0, 0}, image), options, regions);
  return regions;
}

}  // namespace gaitcam
