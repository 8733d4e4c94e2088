#include "algorithms/core/trajectory.h"

#include <algorithm>

#include "algorithms/core/errors.h"

namespace gaitcam {

double PathLength(const Trajectory& trajectory) {
  double length = 0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm();
  }
  return length;
}

std::optional<Pose> PoseAt(const Trajectory& trajectory, int64_t stamp_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                                      [](const StampedPose& p, int64_t stamp) { return p.stamp_ns < stamp; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& a = *(after - 1);
  const double s = double(stamp_ns - a.stamp_ns) / double(after->stamp_ns - a.stamp_ns);
  return Interpolate(a.pose, after->pose, s);
}

void CheckStampsIncrease(const Trajectory& trajectory, const std::string& what) {
  for (size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory[i].stamp_ns > trajectory[i - 1].stamp_ns) continue;
    throw BadInput(what + ": stamp of entry " + std::to_string(i + 1) + " (" + std::to_string(trajectory[i].stamp_ns) +
                   " ns) does not follow that of entry " + std::to_string(i) + "; stamps must increase");
  }
}

}  // namespace gaitcam
