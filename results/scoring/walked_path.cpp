#include "results/scoring/walked_path.h"

#include <cmath>
#include <numbers>

namespace gaitcam {
namespace {

/// Value at pair i of the line that fits pairs [begin, end) best, weights falling to 0 at `window_s`.
Eigen::Vector3d FitLineAt(const std::vector<PosePair>& pairs, size_t i, size_t begin, size_t end, double window_s) {
  double w0 = 0, w1 = 0, w2 = 0;
  Eigen::Vector3d p0(0, 0, 0), p1(0, 0, 0);
  for (size_t k = begin; k < end; ++k) {
    const double t = 1e-9 * double(pairs[k].stamp_ns - pairs[i].stamp_ns);
    const double w = 0.5 + 0.5 * std::cos(std::numbers::pi * t / window_s);
    const Eigen::Vector3d p = pairs[k].truth.translation - pairs[i].truth.translation;
    w0 += w;
    w1 += w * t;
    w2 += w * t * t;
    p0 += w * p;
    p1 += w * t * p;
  }
  const double determinant = w0 * w2 - w1 * w1;
  if (!(determinant > 1e-12 * w0 * w2)) return pairs[i].truth.translation;  // alone in its window
  return pairs[i].truth.translation + (w2 * p0 - w1 * p1) / determinant;
}

}  // namespace

std::vector<double> WalkedPath(const std::vector<PosePair>& pairs, double window_s) {
  const int64_t window_ns = std::llround(1e9 * window_s);
  std::vector<double> gone(pairs.size(), 0.0);
  Eigen::Vector3d before(0, 0, 0);
  size_t begin = 0, end = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    while (pairs[i].stamp_ns - pairs[begin].stamp_ns > window_ns) ++begin;
    while (end < pairs.size() && pairs[end].stamp_ns - pairs[i].stamp_ns <= window_ns) ++end;
    const Eigen::Vector3d now = window_ns > 0 ? FitLineAt(pairs, i, begin, end, window_s) : pairs[i].truth.translation;
    if (i > 0) gone[i] = gone[i - 1] + (now - before).norm();
    before = now;
  }
  return gone;
}

}  // namespace gaitcam
