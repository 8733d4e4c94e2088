/// A crowd in a scene.

#pragma once

#include "models/code/people/crowd.h"
#include "models/code/scenes/scene.h"

namespace gaitcam {

/// What of a scene decides how a crowd moves in it.
CrowdRoom RoomOf(const Scene& scene);

/// Simulates a crowd and adds its people, instead of those of a crowd that was added before.
/// @param robot its planned course, m; none if there is no robot. @param duration_s of the run. @param seed unless the
/// crowd has its own.
/// @throws BadInput in one line if the crowd does not fit the scene.
void AddCrowd(const CrowdEntry& crowd, const RobotCourse& robot, double duration_s, uint64_t seed, Scene& scene);

}  // namespace gaitcam
