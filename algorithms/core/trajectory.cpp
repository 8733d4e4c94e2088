#include "algorithms/core/trajectory.h"

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"

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

std::optional<Pose> SmoothPoseAt(const Trajectory& trajectory, int64_t stamp_ns, int64_t max_gap_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                                      [](const StampedPose& p, int64_t stamp) { return p.stamp_ns < stamp; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == trajectory.begin() || after->stamp_ns - (after - 1)->stamp_ns > max_gap_ns) return std::nullopt;
  auto first = after - 1, last = after;
  if (first != trajectory.begin() && first->stamp_ns - (first - 1)->stamp_ns <= max_gap_ns) --first;
  if (last + 1 != trajectory.end() && (last + 1)->stamp_ns - last->stamp_ns <= max_gap_ns) ++last;
  const Pose& near = (after - 1)->pose;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), turned = moved;  // since `near`, by Lagrange's polynomials
  for (auto k = first; k <= last; ++k) {
    double weight = 1;
    for (auto m = first; m <= last; ++m) {
      if (m != k) weight *= double(stamp_ns - m->stamp_ns) / double(k->stamp_ns - m->stamp_ns);
    }
    moved += weight * (k->pose.translation - near.translation);
    turned += weight * LogSo3(near.rotation.conjugate() * k->pose.rotation);
  }
  return Pose(near.rotation * ExpSo3(turned), near.translation + moved);
}

void CheckStampsIncrease(const Trajectory& trajectory, const std::string& what) {
  for (size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory[i].stamp_ns > trajectory[i - 1].stamp_ns) continue;
    throw BadInput(what + ": stamp of entry " + std::to_string(i + 1) + " (" + std::to_string(trajectory[i].stamp_ns) +
                   " ns) does not follow that of entry " + std::to_string(i) + "; stamps must increase");
  }
}

}  // namespace gaitcam
