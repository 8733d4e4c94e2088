/// A crowd in a scene.

#pragma once

#include "models/code/people/crowd.h"
#include "models/code/scenes/scene.h"

namespace gaitcam {

/// What of a scene decides how a crowd moves in it.
CrowdRoom RoomOf(const Scene& scene);

/// Simulates a crowd and adds its people, instead of those of a crowd that was added before.
/// @throws BadInput in one line if the crowd does not fit the scene.
void AddCrowd(const CrowdPlan& plan, Scene& scene);

}  // namespace gaitcam
