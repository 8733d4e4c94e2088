/// A crowd that walks to goals of its own: simulated ahead of a run, so that anybody's pose is a function of time.
///
/// Social forces (crowd_forces.h) decide how walkers turn and slow down for each other, for the robot, walls and
/// furniture; ways around these lead them from goal to goal (floor_map.h). Forces alone do not rule out that somebody
/// touches somebody: whoever comes too near after a step of the simulation is set back, as hard discs would be.

#pragma once

#include <cstdint>
#include <vector>

#include "models/code/people/crowd_cast.h"

namespace gaitcam {

/// Between the middles of two walkers, and from a walker's middle to walls and furniture, m: what the simulation keeps.
/// The body follows it in footsteps, a few centimetres beside.
inline constexpr double kCrowdApart_m = 0.66, kCrowdFromWalls_m = 0.35;

/// The people of a crowd, with their courses from two seconds before the run to its end, where they come to stand.
/// The same arguments give the same people. Those who stand, sit, talk or queue stay where they are.
/// @param robot as planned; people keep crowd.keep_off_m away from it, and stay nowhere on its course.
/// @throws BadInput in one line: a crowd that does not fit its room, a goal that cannot be reached.
std::vector<PersonOptions> SimulateCrowd(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot,
                                         double duration_s, uint64_t seed);

}  // namespace gaitcam
