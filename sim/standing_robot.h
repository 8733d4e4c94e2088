/// A robot that is put down here and there to look around: what the references and queries of a localisation are made
/// of. Physics, servos and camera are those of a walk; the place and its pictures are made ready once for all poses.

#pragma once

#include <vector>

#include "sim/simulation.h"

namespace gaitcam {

class StandingRobot {
 public:
  /// @param options where it stands, its path and how long do not matter.
  /// @throws BadInput, MissingResource as Simulation does; BadOption if it cannot look all around.
  StandingRobot(const Robot& robot, const Place& place, SimulationOptions options, uint64_t seed);

  const Calibration& calibration() const { return simulation_.calibration(); }
  const EglContext& gl() const { return simulation_.gl(); }

  /// The frames of one scan's sweeps, in order, each with its scan state. The sweeps alone are filmed.
  /// @param pose x m, y m, yaw deg. @param seed of this pose's noise.
  /// @throws BadInput if the robot falls over, as it does inside of furniture.
  std::vector<SimulatedFrame> Scan(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth = {});
  /// One frame of what it sees straight ahead, once it has come to rest. Parameters and errors likewise.
  SimulatedFrame View(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth = {});

 private:
  [[noreturn]] void Fell(const Eigen::Vector3d& pose) const;

  Simulation simulation_;
};

}  // namespace gaitcam
