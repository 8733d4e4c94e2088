#include "algorithms/features/hessian_detector.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>
#include <optional>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kBorder = 4;  ///< Pixels at an octave's border where derivatives see beyond the image.

using Row = Eigen::Map<const Eigen::ArrayXf>;

/// `n` values of a row from column 2 + dx on.
Row Span(const cv::Mat& light, int y, int dx, int n) { return {light.ptr<float>(y) + 2 + dx, n}; }

/// The three levels around one, as a function of place and scale to climb.
struct Neighbourhood {
  const cv::Mat *below, *here, *above;

  float At(int dx, int dy, int ds, int x, int y) const {
    const cv::Mat& m = ds < 0 ? *below : ds > 0 ? *above : *here;
    return m.ptr<float>(y + dy)[x + dx];
  }
  /// Greater (sign 1) or less (sign -1) than all 26 neighbours. Those in the same row first: they fail most often.
  bool IsExtremum(int x, int y, float sign) const {
    const float v = sign * here->ptr<float>(y)[x];
    const auto beats = [&](const float* r) { return v > sign * r[-1] && v > sign * r[0] && v > sign * r[1]; };
    const float* row = here->ptr<float>(y) + x;
    if (!(v > sign * row[-1] && v > sign * row[1])) return false;
    if (!beats(here->ptr<float>(y - 1) + x) || !beats(here->ptr<float>(y + 1) + x)) return false;
    for (const cv::Mat* level : {below, above})
      for (int dy = -1; dy <= 1; ++dy)
        if (!beats(level->ptr<float>(y + dy) + x)) return false;
    return true;
  }
};

/// Where the quadratic through a maximum and its neighbours peaks (Brown and Lowe 2002): offsets in x, y and level.
std::optional<Eigen::Vector3f> QuadraticPeak(const Neighbourhood& n, int x, int y) {
  const auto d = [&](int dx, int dy, int ds) { return n.At(dx, dy, ds, x, y); };
  const Eigen::Vector3f gradient(0.5f * (d(1, 0, 0) - d(-1, 0, 0)), 0.5f * (d(0, 1, 0) - d(0, -1, 0)),
                                 0.5f * (d(0, 0, 1) - d(0, 0, -1)));
  const float v2 = 2 * d(0, 0, 0);
  const float xy = 0.25f * (d(1, 1, 0) - d(1, -1, 0) - d(-1, 1, 0) + d(-1, -1, 0));
  const float xs = 0.25f * (d(1, 0, 1) - d(1, 0, -1) - d(-1, 0, 1) + d(-1, 0, -1));
  const float ys = 0.25f * (d(0, 1, 1) - d(0, 1, -1) - d(0, -1, 1) + d(0, -1, -1));
  Eigen::Matrix3f hessian;
  hessian << d(1, 0, 0) + d(-1, 0, 0) - v2, xy, xs,  //
      xy, d(0, 1, 0) + d(0, -1, 0) - v2, ys,         //
      xs, ys, d(0, 0, 1) + d(0, 0, -1) - v2;
  Eigen::Matrix3f inverse;
  bool invertible = false;
  hessian.computeInverseWithCheck(inverse, invertible, 1e-20f);
  if (!invertible) return std::nullopt;
  // A peak further than the next sample belongs to a plateau: keep near the sample that is the maximum.
  return Eigen::Vector3f((-inverse * gradient).cwiseMax(-0.6f).cwiseMin(0.6f));
}

/// Trace squared over determinant grows with the ratio r of the eigenvalues as (r + 1)^2 / r.
bool IsEdge(const ScaleLevel& level, int x, int y, double max_anisotropy) {
  const cv::Mat& l = level.light;
  const auto at = [&](int dx, int dy) { return l.ptr<float>(y + dy)[x + dx]; };
  const float xx = at(1, 0) + at(-1, 0) - 2 * at(0, 0), yy = at(0, 1) + at(0, -1) - 2 * at(0, 0);
  const float xy = 0.25f * (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1));
  const double det = double(xx) * yy - double(xy) * xy, trace = double(xx) + yy, r = max_anisotropy;
  return det <= 0 || trace * trace * r > det * (r + 1) * (r + 1);
}

/// A dark blob is a minimum of the light: its curvature is positive.
PointKind KindOf(const ScaleLevel& level, int x, int y, bool blob) {
  if (!blob) return PointKind::kSaddle;
  const cv::Mat& l = level.light;
  const float* row = l.ptr<float>(y) + x;
  const float curvature = row[2] + row[-2] + l.ptr<float>(y + 2)[x] + l.ptr<float>(y - 2)[x] - 4 * row[0];
  return curvature > 0 ? PointKind::kDark : PointKind::kBright;
}

/// Which of four pixels beat the threshold and their neighbours in the row and in the column: few are left to look at.
/// @returns one bit for each.
int MayBeExtrema(const float* row, size_t stride, float threshold, bool minima) {
  using cv::v_load;
  const cv::v_float32x4 here = v_load(row), left = v_load(row - 1), right = v_load(row + 1), up = v_load(row - stride),
                        down = v_load(row + stride), limit = cv::v_setall_f32(threshold);
  cv::v_float32x4 found = (here > limit) & (here > left) & (here > right) & (here > up) & (here > down);
  if (minima) {
    const cv::v_float32x4 low = cv::v_setall_f32(-threshold);
    found = found | ((here < low) & (here < left) & (here < right) & (here < up) & (here < down));
  }
  return cv::v_signmask(found);
}

/// Extrema of one level, between its neighbours in scale.
void FindExtrema(const ScaleOctave& octave, const std::vector<cv::Mat>& determinants, ScalePoint point,
                 const HessianOptions& options, std::vector<ScalePoint>& points) {
  const size_t l = size_t(point.level);
  const Neighbourhood near{&determinants[l - 1], &determinants[l], &determinants[l + 1]};
  const double intervals = 1 / std::log2(octave.levels[1].sigma / octave.levels[0].sigma);
  const float threshold = float(options.threshold);
  const auto look = [&](const float* row, int x, int y) {
    const bool blob = row[x] > threshold, saddle = options.saddles && row[x] < -threshold;
    if (!(blob || saddle) || !near.IsExtremum(x, y, blob ? 1.f : -1.f)) return;
    if (blob && options.max_anisotropy > 0 && IsEdge(octave.levels[l], x, y, options.max_anisotropy)) return;
    const std::optional<Eigen::Vector3f> offset = QuadraticPeak(near, x, y);
    if (!offset) return;
    point.x = float(x) + offset->x();
    point.y = float(y) + offset->y();
    point.scale = float(octave.levels[l].sigma * std::exp2(offset->z() / intervals));
    point.response = std::abs(row[x]);
    point.kind = KindOf(octave.levels[l], x, y, blob);
    points.push_back(point);
  };
  constexpr int kFourPixels = 4;
  const size_t stride = near.here->step1();
  for (int y = kBorder; y < near.here->rows - kBorder; ++y) {
    const float* row = near.here->ptr<float>(y);
    int x = kBorder;
    for (; x + kFourPixels <= near.here->cols - kBorder; x += kFourPixels) {
      const int which = MayBeExtrema(row + x, stride, threshold, options.saddles);
      for (int k = 0; which >> k != 0; ++k) {
        if ((which >> k & 1) != 0) look(row, x + k, y);
      }
    }
    for (; x < near.here->cols - kBorder; ++x) look(row, x, y);
  }
}

void KeepStrongest(std::vector<ScalePoint>& points, size_t most) {
  if (points.size() <= most) return;
  std::vector<float> responses;
  for (const ScalePoint& p : points) responses.push_back(p.response);
  std::nth_element(responses.begin(), responses.begin() + long(most), responses.end(), std::greater<>());
  const float limit = responses[most];  // ties at the limit all go, so that the choice depends on values alone
  std::erase_if(points, [&](const ScalePoint& p) { return p.response <= limit; });
}

}  // namespace

cv::Mat HessianDeterminant(const ScaleLevel& level, bool compact) {
  const cv::Mat& l = level.light;
  GAITCAM_ASSERT(l.type() == CV_32FC1);
  cv::Mat determinant = cv::Mat::zeros(l.size(), CV_32FC1);
  const int n = l.cols - 4, step = compact ? 1 : 2;
  // Equation 5.9 has differences over two pixels and no factor 1/2: its second derivatives are four times too large.
  const float h = float(step);
  const float norm = float(std::pow(level.sigma, 4)) / (h * h * h * h);
  for (int y = 2; y < l.rows - 2 && n > 0; ++y) {
    const auto at = [&](int dx, int dy) { return Span(l, y + dy, dx, n); };
    Eigen::Map<Eigen::ArrayXf> out(determinant.ptr<float>(y) + 2, n);
    const auto xx = at(step, 0) + at(-step, 0) - 2 * at(0, 0);
    const auto yy = at(0, step) + at(0, -step) - 2 * at(0, 0);
    const auto xy = (h * h / 4) * (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1));
    out = norm * (xx * yy - xy.square());  // equation 5.8
  }
  return determinant;
}

std::vector<ScalePoint> DetectHessian(const ScaleSpace& space, const HessianOptions& options, const cv::Rect& region) {
  CheckFields(options);
  std::vector<ScalePoint> points;
  for (size_t o = 0; o < space.size(); ++o) {
    std::vector<cv::Mat> determinants;
    for (const ScaleLevel& level : space[o].levels) determinants.push_back(HessianDeterminant(level, options.compact));
    for (size_t l = 1; l + 1 < determinants.size(); ++l) {
      ScalePoint point;
      point.octave = int(o);
      point.level = int(l);
      FindExtrema(space[o], determinants, point, options, points);
    }
  }
  if (!region.empty()) {
    std::erase_if(points, [&](const ScalePoint& p) {
      const ScaleOctave& octave = space[size_t(p.octave)];
      const double x = octave.origin_px + octave.pitch_px * p.x, y = octave.origin_px + octave.pitch_px * p.y;
      return !(x >= region.x - 0.5 && x < region.br().x - 0.5 && y >= region.y - 0.5 && y < region.br().y - 0.5);
    });
  }
  KeepStrongest(points, size_t(options.max_points));
  return points;
}

}  // namespace gaitcam
