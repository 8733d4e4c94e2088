#include "sim/walking/gait_plan.h"

#include <cmath>
#include <utility>

namespace gaitcam {
namespace {

constexpr int kInitialIterations = 30;  // from no knowledge of the centre of mass to rounding

/// Standing on the path's first two prints with the centre of mass where the planned ZMP rests.
Posture::Targets StandingTargets(const FootstepPlanner& planner, const LegKinematics& leg, double zmp_forward_m) {
  Posture::Targets targets;
  for (const int side : {0, 1}) targets.X_PA[side] = planner.print(side).ankle.Lifted(leg.ankle_height());
  const PlanarPose center = planner.Center(planner.print(0));
  targets.com = center * Eigen::Vector2d(zmp_forward_m, 0);
  targets.heading = center.heading;
  return targets;
}

}  // namespace

GaitPlan PlanGait(const Robot& robot, const mjModel* nominal, const WalkerOptions& options, const GaitOptions& gait,
                  const PathOptions& path, double control_period_s, const Pose& start) {
  const LegKinematics leg(robot, 0);
  Posture posture(robot, nominal, RootHeight(leg, gait.crouch_m), options.lean_rad);

  SteeringOptions steering;
  steering.max_turn_rad = options.max_turn_rad;
  steering.heading_gain = options.heading_gain;
  steering.offset_gain = options.offset_gain;
  FootstepPlanner planner(gait, steering, Path(path, start));

  WalkPatternOptions timing;
  timing.control_period_s = control_period_s;
  timing.settle_s = path.settle_s;
  timing.preview_s = options.preview_s;
  timing.landing_phase = options.landing_phase;
  timing.zmp_forward_m = leg.sole().x() + options.zmp_forward_m;
  timing.zmp_inward_m = options.zmp_inward_m;
  timing.ankle_height_m = leg.ankle_height();

  const Posture::Solution initial =
      posture.Solve(StandingTargets(planner, leg, timing.zmp_forward_m), kInitialIterations);
  timing.com_height_m = posture.com_height();
  const double natural_frequency = std::sqrt(kGravity / timing.com_height_m);
  return {std::move(posture), initial, WalkPattern(gait, timing, std::move(planner)), natural_frequency};
}

}  // namespace gaitcam
