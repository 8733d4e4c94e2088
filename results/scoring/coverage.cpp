#include "results/scoring/coverage.h"

#include <algorithm>

#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

double InlierRatio(const std::vector<FrameEstimate>& answer) {
  double sum = 0;
  int frames = 0;
  for (const FrameEstimate& frame : answer) {
    if (!frame.pose || frame.matches <= 0) continue;
    sum += double(frame.inliers) / frame.matches;
    ++frames;
  }
  return frames > 0 ? sum / frames : kNaN;
}

double TimeCoverage(const std::vector<PosePair>& pairs, const Trajectory& truth) {
  std::vector<double> gaps;
  for (size_t i = 1; i < pairs.size(); ++i) gaps.push_back(SecondsBetween(pairs[i - 1].stamp_ns, pairs[i].stamp_ns));
  const double max_gap = 2.5 * MedianOf(gaps);
  double covered = 0;
  for (const double gap : gaps) covered += gap <= max_gap ? gap : 0;
  const double span = truth.size() < 2 ? 0 : SecondsBetween(truth.front().stamp_ns, truth.back().stamp_ns);
  return span > 0 ? covered / span : 0;
}

}  // namespace

Coverage MeasureCoverage(const std::vector<FrameEstimate>& answer, bool keyframes_only, const Trajectory& truth,
                         const std::vector<PosePair>& pairs, const std::vector<int64_t>& frame_stamps) {
  Coverage c;
  c.time_to_first_pose_s = kNaN;
  c.inlier_ratio = InlierRatio(answer);
  std::vector<int64_t> posed;
  for (const FrameEstimate& frame : answer) {
    if (frame.restarted && !posed.empty()) ++c.restarts;  // the first world is no restart
    if (frame.pose) posed.push_back(frame.stamp_ns);
  }
  c.tracked = posed.size();
  c.frames_known = !frame_stamps.empty();
  if (!c.frames_known) {
    c.frames = answer.size();
    c.ratio = TimeCoverage(pairs, truth);
    return c;
  }
  c.frames = frame_stamps.size();
  c.ratio = double(pairs.size()) / double(c.frames);
  if (posed.empty()) {
    c.initializing = c.frames;
    return c;
  }
  c.time_to_first_pose_s = SecondsBetween(frame_stamps.front(), posed.front());
  for (const int64_t stamp : frame_stamps) {
    if (std::binary_search(posed.begin(), posed.end(), stamp)) continue;
    const bool is_between = keyframes_only && stamp > posed.front() && stamp < posed.back();
    if (!is_between) ++(stamp < posed.front() ? c.initializing : c.lost);
  }
  if (keyframes_only) c.ratio = 1 - double(c.initializing + c.lost) / double(c.frames);
  return c;
}

}  // namespace gaitcam
