#include "sim/walking/planned_course.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "algorithms/core/pose.h"
#include "sim/walking/footsteps.h"

namespace gaitcam {
namespace {

/// From print to print; the first two are those that the robot stands on.
PlannedCourse PlanWalking(const GaitOptions& gait, const PathOptions& path, const Pose& start) {
  FootstepPlanner planner(gait, {}, Path(path, start));
  std::vector<PlanarPose> centers{planner.Center(planner.print(1))};
  while (!planner.complete()) {
    planner.Append({}, planner.count());
    centers.push_back(planner.Center(planner.print(planner.count() - 1)));
  }
  return [centers, settle_s = path.settle_s, period_s = gait.period_s](double time_s) {
    const double at = std::clamp((time_s - settle_s) / period_s, 0.0, double(centers.size() - 1));
    const size_t i = std::min(size_t(at), centers.size() - 1), next = std::min(i + 1, centers.size() - 1);
    const double part = at - double(i);
    return PlanarPose(centers[i].position + part * (centers[next].position - centers[i].position),
                      centers[i].heading + part * WrapAngle(centers[next].heading - centers[i].heading));
  };
}

}  // namespace

PlannedCourse PlanCourse(const Robot& robot, const GaitOptions& gait, const OmniDriveOptions& drive,
                         const PathOptions& path, const Pose& start) {
  if (robot.kind == Robot::Kind::kOmniBase) return PlanDriving(drive, path, start);
  return PlanWalking(gait, path, start);
}

}  // namespace gaitcam
