/// Where a robot is going to be, as planned before it starts.

#pragma once

#include <functional>

#include "models/code/robots/robot.h"
#include "sim/walking/omni_drive.h"

namespace gaitcam {

/// The pose of the robot's middle in W at a time of the run, s; any time, also negative.
using PlannedCourse = std::function<PlanarPose(double time_s)>;

/// The course along a path that nothing disturbs: no slip, no fall, no scan and no command of a system. A wheeled base
/// keeps to it within a centimetre or two; a humanoid lags and strays as its feet slip.
/// @param gait of a humanoid. @param drive of a wheeled base. @throws BadOption as Path does.
PlannedCourse PlanCourse(const Robot& robot, const GaitOptions& gait, const OmniDriveOptions& drive,
                         const PathOptions& path, const Pose& start);

}  // namespace gaitcam
