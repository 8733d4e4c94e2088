/// A gait made ready to be walked by a robot along a path: posture solver, timed pattern, and where both begin.

#pragma once

#include "models/code/robots/robot.h"
#include "sim/walking/path.h"
#include "sim/walking/posture.h"
#include "sim/walking/walk_pattern.h"
#include "sim/walking/walker.h"

namespace gaitcam {

struct GaitPlan {
  Posture posture;
  Posture::Solution initial;  ///< Standing on both feet at the path's start.
  WalkPattern pattern;
  double natural_frequency = 0;  ///< Of the pendulum under the centre of mass, 1/s.
};

GaitPlan PlanGait(const Robot& robot, const mjModel* nominal, const WalkerOptions& options, const GaitOptions& gait,
                  const PathOptions& path, double control_period_s, const Pose& start);

}  // namespace gaitcam
