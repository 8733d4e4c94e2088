/// A crowd that walks to goals of its own.
///
/// Social forces (crowd_forces.h) decide how walkers turn and slow down for each other, for the robot, walls and
/// furniture; ways around these lead them from goal to goal (floor_map.h). Forces alone do not rule out that somebody
/// touches somebody: whoever comes too near after a step of the simulation is set back, as hard discs would be.
///
/// Where the robot's course is known, the crowd is simulated ahead of a run, and anybody's pose is a function of time.
/// Where a system steers the robot, the crowd goes on beside the run and minds where the robot really is (LiveCrowd).

#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "models/code/people/crowd_cast.h"
#include "models/code/people/person_walk.h"

namespace gaitcam {

/// Between the middles of two walkers, and from a walker's middle to walls and furniture, m: what the simulation keeps.
/// The body follows it in footsteps, a few centimetres beside.
inline constexpr double kCrowdApart_m = 0.66, kCrowdFromWalls_m = 0.35;

/// All that decides who the people of a crowd are and, but for the room, where they go.
struct CrowdPlan {
  CrowdEntry crowd;
  RobotCourse robot;  ///< As planned; people stay nowhere on its course.
  double duration_s = 0;
  uint64_t seed = 0;  ///< Of a crowd that has none of its own.
};

/// The people of a crowd, with their courses from two seconds before the run to its end, where they come to stand.
/// The same arguments give the same people. Those who stand, sit, talk or queue stay where they are. Walkers keep
/// crowd.keep_off_m away from the robot where it is planned to be.
/// @throws BadInput in one line: a crowd that does not fit its room, a goal that cannot be reached.
std::vector<PersonOptions> SimulateCrowd(const CrowdPlan& plan, const CrowdRoom& room);

/// The crowd that SimulateCrowd makes, but from time 0 on walkers keep away from where the robot is. They see the robot
/// and each other as they are now and expect it to go on as it does, or to stop at any moment; what they see changes
/// the steps that begin PersonWalk::kPlanned_s later, as a walker's next steps are under way already.
class LiveCrowd {
 public:
  /// @throws BadInput as SimulateCrowd.
  LiveCrowd(const CrowdPlan& plan, const CrowdRoom& room);
  LiveCrowd(LiveCrowd&&) noexcept;
  ~LiveCrowd();

  size_t size() const;
  /// @param time_s of the run: 0 or later, and not before the last call's. @param robot where its middle is, m.
  /// @returns whether walkers have changed their minds: then Replan is to be called.
  bool Advance(double time_s, const Eigen::Vector2d& robot);
  /// @param walks of all people of the crowd, in SimulateCrowd's order; they change from the present time on.
  void Replan(std::span<PersonWalk> walks);

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gaitcam
