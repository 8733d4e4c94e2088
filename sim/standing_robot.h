/// A robot placed at given poses to film from there: references and queries of localisation experiments. Physics,
/// servos and camera are those of a walk; the scene is built once for all poses.

#pragma once

#include <vector>

#include "sim/simulation.h"

namespace gaitcam {

class StandingRobot {
 public:
  /// @param options its path, start and duration are not used.
  /// @throws BadInput, MissingResource as Simulation does; BadOption if its head cannot scan 360 degrees.
  StandingRobot(const Robot& robot, const Scene& scene, SimulationOptions options, uint64_t seed);

  const Calibration& calibration() const { return simulation_.calibration(); }
  const EglContext& gl() const { return simulation_.gl(); }

  /// The frames of one head scan, in order, each with its scan state. Only the sweeps are filmed.
  /// @param pose x m, y m, yaw deg. @param seed of this pose's noise.
  /// @throws BadInput if the robot falls, for example because the pose lies inside furniture.
  std::vector<SimulatedFrame> Scan(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth = {});
  /// One frame with the head straight ahead, after the robot has settled. Parameters and errors as for Scan.
  SimulatedFrame View(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth = {});

 private:
  [[noreturn]] void Fell(const Eigen::Vector3d& pose) const;

  Simulation simulation_;
};

}  // namespace gaitcam
