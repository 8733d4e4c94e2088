#include "results/scoring/metrics.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

/// Paths shorter than this count as no motion, m.
constexpr double kMinPath_m = 1e-6;

/// Path length added by each pair, m; 0 for the first.
std::vector<double> PathSteps(const std::vector<PosePair>& pairs, RpePath path) {
  std::vector<double> steps(pairs.size(), 0.0);
  std::vector<double> walked;
  if (path == RpePath::kWalked) walked = WalkedPath(pairs);
  for (size_t i = 1; i < pairs.size(); ++i) {
    switch (path) {
      case RpePath::kWalked: steps[i] = walked[i] - walked[i - 1]; break;
      case RpePath::kTruth: steps[i] = (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm(); break;
      case RpePath::kEstimate:
        steps[i] = (pairs[i].estimate.translation - pairs[i - 1].estimate.translation).norm();
        break;
    }
  }
  return steps;
}

std::vector<double> Accumulate(const std::vector<double>& steps) {
  std::vector<double> sums(steps.size());
  std::partial_sum(steps.begin(), steps.end(), sums.begin());
  return sums;
}

RelativeError ErrorBetween(const std::vector<PosePair>& pairs, size_t from, size_t to) {
  const Pose truth = pairs[from].truth.Inverse() * pairs[to].truth;
  const Pose estimate = pairs[from].estimate.Inverse() * pairs[to].estimate;
  const Pose error = truth.Inverse() * estimate;
  return {from, to, error.translation.norm(), RotationAngle(Eigen::Quaterniond::Identity(), error.rotation)};
}

/// After `from`, the first index whose coordinate is nearest to `delta` beyond that of `from`. Coordinates do not
/// decrease.
size_t NearestAhead(const std::vector<double>& coordinate, size_t from, double delta) {
  const auto begin = coordinate.begin() + ptrdiff_t(from) + 1;
  const auto gone = [&](double c) { return c - coordinate[from]; };
  auto found = std::partition_point(begin, coordinate.end(), [&](double c) { return gone(c) < delta; });
  if (found == coordinate.end() ||
      (found != begin && std::abs(gone(*(found - 1)) - delta) <= std::abs(gone(*found) - delta))) {
    --found;
  }
  found = std::lower_bound(begin, found, *found);  // standing still: the first of equals
  return size_t(found - coordinate.begin());
}

using IntervalList = std::vector<std::pair<size_t, size_t>>;

/// Every pose starts an interval, if one ends near enough to `delta` ahead of it.
IntervalList OverlappingIntervals(const std::vector<double>& steps, const RelativeOptions& options) {
  const std::vector<double> coordinate = Accumulate(steps);
  IntervalList intervals;
  for (size_t i = 0; i + 1 < coordinate.size(); ++i) {
    const size_t j = NearestAhead(coordinate, i, options.delta);
    const double difference = std::abs(coordinate[j] - coordinate[i] - options.delta);
    if (difference <= options.tolerance_ratio * options.delta) intervals.emplace_back(i, j);
  }
  return intervals;
}

/// Marks are set wherever another `delta` has been gone, the first of them one delta in (as evo has it); intervals lie
/// between them.
IntervalList ConsecutiveIntervals(const std::vector<double>& steps, const RelativeOptions& options) {
  IntervalList intervals;
  size_t mark = 0;
  double gone = 0;
  for (size_t i = 1; i < steps.size(); ++i) {
    gone += steps[i];
    if (gone < options.delta) continue;
    if (mark > 0) intervals.emplace_back(mark, i);
    mark = i;
    gone = 0;
  }
  return intervals;
}

IntervalList FrameIntervals(size_t count, const RelativeOptions& options) {
  GAITCAM_ASSERT(options.delta >= 1 && options.delta == std::floor(options.delta));
  const size_t delta = size_t(options.delta);
  IntervalList intervals;
  for (size_t i = 0; i + delta < count; i += options.all_pairs ? 1 : delta) intervals.emplace_back(i, i + delta);
  return intervals;
}

/// Rotation from pose i to pose j as a vector, seen in the frame of pose i.
Eigen::Vector3d RotationVector(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(from.conjugate() * to);
  return WrapAngle(turn.angle()) * turn.axis();
}

/// Indices where the heading changes its direction of turning for good, the ends included.
std::vector<size_t> TurningPoints(const std::vector<double>& heading, double hysteresis) {
  std::vector<size_t> points = {0};
  size_t extreme = 0, lowest = 0,
         highest = 0;  // the extreme in the current direction; in both directions while it is undetermined
  int direction = 0;   // +1 left, -1 right, 0 undetermined
  for (size_t i = 1; i < heading.size(); ++i) {
    if (direction == 0) {
      if (heading[i] > heading[highest]) highest = i;
      if (heading[i] < heading[lowest]) lowest = i;
      if (heading[i] - heading[lowest] > hysteresis) direction = +1;
      if (heading[highest] - heading[i] > hysteresis) direction = -1;
      extreme = i;
    } else if (direction * (heading[i] - heading[extreme]) > 0) {
      extreme = i;
    } else if (direction * (heading[extreme] - heading[i]) > hysteresis) {
      points.push_back(extreme);
      direction = -direction;
      extreme = i;
    }
  }
  if (heading.size() > 1) points.push_back(heading.size() - 1);
  return points;
}

double MedianSlope(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes;
  for (size_t i = 0; i < x.size(); ++i) {
    for (size_t j = i + 1; j < x.size(); ++j) {
      if (x[j] > x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
    }
  }
  return MedianOf(std::move(slopes));
}

}  // namespace

Statistics Summarize(std::vector<double> values) {
  Statistics s{values.size(), kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
  if (values.empty()) return s;
  const double n = double(values.size());
  double squares = 0, deviations = 0;
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  for (const double v : values) {
    squares += v * v;
    deviations += (v - s.mean) * (v - s.mean);
  }
  s.rmse = std::sqrt(squares / n);
  s.std = std::sqrt(deviations / n);
  s.median = MedianOf(values);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  s.min = *low;
  s.max = *high;
  return s;
}

std::vector<double> PositionErrors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& p : pairs) errors.push_back((p.estimate.translation - p.truth.translation).norm());
  return errors;
}

std::vector<double> RotationErrors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& p : pairs) errors.push_back(RotationAngle(p.estimate.rotation, p.truth.rotation));
  return errors;
}

std::vector<double> InDegrees(std::vector<double> radians) {
  for (double& v : radians) v *= kDegPerRad;
  return radians;
}

std::vector<double> FullErrors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& p : pairs) {
    errors.push_back(((p.estimate.Inverse() * p.truth).Matrix() - Eigen::Matrix4d::Identity()).norm());
  }
  return errors;
}

std::vector<RelativeError> RelativeErrors(const std::vector<PosePair>& pairs, const RelativeOptions& options) {
  IntervalList intervals;
  if (options.unit == DeltaUnit::kFrames) {
    intervals = FrameIntervals(pairs.size(), options);
  } else {
    std::vector<double> steps(pairs.size(), 0.0);
    if (options.unit == DeltaUnit::kMeters) steps = PathSteps(pairs, options.path);
    for (size_t i = 1; i < pairs.size() && options.unit == DeltaUnit::kSeconds; ++i) {
      steps[i] = double(pairs[i].stamp_ns - pairs[i - 1].stamp_ns) * 1e-9;
    }
    intervals = options.all_pairs ? OverlappingIntervals(steps, options) : ConsecutiveIntervals(steps, options);
  }
  std::vector<RelativeError> errors;
  for (const auto& [from, to] : intervals) errors.push_back(ErrorBetween(pairs, from, to));
  return errors;
}

Drift MeasureDrift(const std::vector<PosePair>& pairs, double sway_window_s) {
  Drift drift{kNaN, kNaN, kNaN};
  const std::vector<double> path = WalkedPath(pairs, sway_window_s);
  if (path.empty() || path.back() < kMinPath_m) return drift;
  double translation = 0, rotation = 0;
  size_t count = 0;
  for (int tenths = 1; tenths <= 8; ++tenths) {
    const double length = path.back() * tenths / 10;
    for (size_t i = 0; i < pairs.size() && path.back() - path[i] >= length; ++i) {
      const size_t j = size_t(std::lower_bound(path.begin(), path.end(), path[i] + length) - path.begin());
      if (j >= path.size()) break;
      const RelativeError error = ErrorBetween(pairs, i, j);
      translation += error.translation_m / (path[j] - path[i]);
      rotation += error.rotation_rad / (path[j] - path[i]);
      ++count;
    }
  }
  if (count > 0) {
    drift.translation_pct = 100 * translation / double(count);
    drift.rotation_deg_per_m = kDegPerRad * rotation / double(count);
  }
  drift.end_pct = 100 * ErrorBetween(pairs, 0, pairs.size() - 1).translation_m / path.back();
  return drift;
}

double ScaleDriftPctPerM(const std::vector<PosePair>& pairs, double sway_window_s) {
  const std::vector<double> path = WalkedPath(pairs, sway_window_s);
  if (path.empty() || path.back() < kMinPath_m) return kNaN;
  const double length = path.back() / 10;
  const size_t stride = 1 + pairs.size() / 300;  // at most 300 sub-paths, 45 thousand slopes
  std::vector<double> gone, log_scale;
  for (size_t i = 0; i < pairs.size(); i += stride) {
    const size_t j = size_t(std::lower_bound(path.begin(), path.end(), path[i] + length) - path.begin());
    if (j >= pairs.size()) break;
    const double truth = (pairs[j].truth.translation - pairs[i].truth.translation).norm();
    const double estimate = (pairs[j].estimate.translation - pairs[i].estimate.translation).norm();
    // Where the path returns on itself the displacement is too small to determine the scale.
    if (truth < 0.2 * length || !(estimate > 0)) continue;
    gone.push_back(0.5 * (path[i] + path[j]));
    log_scale.push_back(std::log(estimate / truth));
  }
  return gone.size() < 5 ? kNaN : 100 * std::expm1(MedianSlope(gone, log_scale));
}

double Turn::Gain(double min_deg) const { return true_rad * kDegPerRad < min_deg ? kNaN : estimated_rad / true_rad; }

TurnCourse MeasureTurnCourse(const std::vector<PosePair>& pairs) {
  TurnCourse course{std::vector<double>(pairs.size(), 0.0), std::vector<double>(pairs.size(), 0.0)};
  for (size_t i = 1; i < pairs.size(); ++i) {
    const PosePair &a = pairs[i - 1], &b = pairs[i];
    const Eigen::Matrix3d R_WC = a.truth.R();
    course.truth[i] = course.truth[i - 1] + (R_WC * RotationVector(a.truth.rotation, b.truth.rotation)).z();
    course.estimate[i] = course.estimate[i - 1] + (R_WC * RotationVector(a.estimate.rotation, b.estimate.rotation)).z();
  }
  return course;
}

Turn MeasureTurn(const std::vector<PosePair>& pairs, double hysteresis_deg) {
  Turn turn;
  if (pairs.empty()) return turn;
  const auto [truth, estimate] = MeasureTurnCourse(pairs);
  const std::vector<size_t> points = TurningPoints(truth, hysteresis_deg / kDegPerRad);
  for (size_t k = 1; k < points.size(); ++k) {
    const double true_change = truth[points[k]] - truth[points[k - 1]];
    const double estimated_change = estimate[points[k]] - estimate[points[k - 1]];
    turn.true_rad += std::abs(true_change);
    turn.estimated_rad += true_change < 0 ? -estimated_change : estimated_change;
  }
  return turn;
}

double PeakMemoryMb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes / 1024;
  }
  return kNaN;
}

}  // namespace gaitcam
