/// Who is in a crowd, how they look, and where they are when it begins.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "algorithms/core/random.h"
#include "models/code/people/crowd_entry.h"
#include "models/code/people/floor_map.h"
#include "models/code/people/people.h"

namespace gaitcam {

/// A place with something to look at, or to sit on.
struct CrowdSpot {
  Eigen::Vector2d at{0, 0};
  double yaw = 0;     ///< Where somebody looks who is there, rad.
  double seat_m = 0;  ///< Height of a seat over the floor; 0: one stands there.
};

/// The floor of a scene, as a crowd sees it.
struct CrowdRoom {
  Eigen::Vector2d min{-3, -3}, max{3, 3};  ///< Nobody walks beyond, m.
  std::vector<FloorPolygon> obstacles;     ///< Walls and furniture.
  std::vector<CrowdSpot> spots;
};

/// Where the robot's middle is planned to be, m, at a time of the run; none: no robot.
using RobotCourse = std::function<Eigen::Vector2d(double time_s)>;

enum class CrowdRole { kWalks, kStands, kTalks, kSits, kQueues };

struct CastMember {
  CrowdRole role = CrowdRole::kWalks;
  Eigen::Vector2d at{0, 0};
  double yaw = 0;  ///< rad
  double seat_m = 0;
  double leave_s = 0;  ///< When somebody who stands or talks walks off; 0: never.
};

/// A place where walkers go.
struct CrowdGoal {
  CrowdSpot spot;
  bool stays = true;  ///< Nobody stays on the robot's course.
};

struct CrowdCast {
  std::vector<CastMember> members;  ///< In the order of CrowdRole; groups are one after the other.
  std::vector<CrowdGoal> goals;
};

/// Colours, height, build and preferred speed. @param random of one person.
PersonOptions DrawCrowdPerson(const CrowdEntry& crowd, RandomStream& random);

/// Puts everybody where there is room, off walls, furniture, each other and the robot's course.
/// @param map of the room; receives those who stay where they are, and its ways are found.
/// @throws BadInput in one line: a crowd that does not fit its room, a goal that cannot be reached.
CrowdCast CastCrowd(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot, double duration_s,
                    uint64_t seed, FloorMap& map);

}  // namespace gaitcam
