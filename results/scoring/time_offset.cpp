#include "results/scoring/time_offset.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

constexpr double kStepMs = 5;
constexpr size_t kMostSteps = 1000;   // of the estimate; more tell no more
constexpr double kWrong_rad = 0.035;  // a step wronger than this counts as one that is so wrong

/// A step of the estimate.
struct TurnStep {
  int64_t from_ns, to_ns;
  Eigen::Quaterniond turn;
};

std::vector<TurnStep> StepsOf(const std::vector<PosePair>& pairs) {
  std::vector<double> gaps;
  for (size_t i = 1; i < pairs.size(); ++i) gaps.push_back(double(pairs[i].stamp_ns - pairs[i - 1].stamp_ns));
  const double longest = gaps.empty() ? 0 : 1.5 * MedianOf(gaps);
  std::vector<TurnStep> steps;
  const size_t stride = 1 + pairs.size() / kMostSteps;
  for (size_t i = 1; i < pairs.size(); i += stride) {
    if (gaps[i - 1] > longest) continue;
    const PosePair &a = pairs[i - 1], &b = pairs[i];
    steps.push_back({a.stamp_ns, b.stamp_ns, a.estimate.rotation.conjugate() * b.estimate.rotation});
  }
  return steps;
}

/// Mean square of what the steps turn otherwise than the truth did `late_ms` before, rad^2. NaN if none can be told.
double Disagreement(const std::vector<TurnStep>& steps, const Trajectory& truth, double late_ms) {
  constexpr int64_t kMaxGap_ns = 150000000;
  const int64_t late_ns = std::llround(1e6 * late_ms);
  double sum = 0;
  size_t count = 0;
  for (const TurnStep& step : steps) {
    const auto a = SmoothPoseAt(truth, step.from_ns - late_ns, kMaxGap_ns);
    const auto b = SmoothPoseAt(truth, step.to_ns - late_ns, kMaxGap_ns);
    if (!a || !b) continue;
    const Eigen::Quaterniond turn = a->rotation.conjugate() * b->rotation;
    sum += std::min(LogSo3(step.turn.conjugate() * turn).squaredNorm(), kWrong_rad * kWrong_rad);
    ++count;
  }
  return count < 10 ? kNaN : sum / double(count);
}

}  // namespace

double EstimateTimeOffsetMs(const std::vector<PosePair>& pairs, const Trajectory& truth, double reach_ms) {
  const std::vector<TurnStep> steps = StepsOf(pairs);
  std::vector<double> disagreement;
  const int reach = int(reach_ms / kStepMs);
  for (int k = -reach; k <= reach; ++k) disagreement.push_back(Disagreement(steps, truth, k * kStepMs));
  if (std::any_of(disagreement.begin(), disagreement.end(), [](double d) { return !std::isfinite(d); })) return kNaN;
  const auto best = std::min_element(disagreement.begin(), disagreement.end());
  const bool at_end = best == disagreement.begin() || best + 1 == disagreement.end();
  if (at_end || *std::max_element(disagreement.begin(), disagreement.end()) < 2 * *best) return kNaN;
  const double before = *(best - 1), after = *(best + 1), bend = before - 2 * *best + after;
  const double vertex = bend > 0 ? 0.5 * (before - after) / bend : 0;
  return kStepMs * (double(best - disagreement.begin()) - reach + vertex);
}

}  // namespace gaitcam
