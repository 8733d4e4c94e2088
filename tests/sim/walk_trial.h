/// One walk without cameras: physics, noisy sensors and a controller, for tests and the walking benchmark.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/robot.h"
#include "sim/path.h"
#include "sim/sensors.h"
#include "sim/world.h"

namespace gaitcam {

struct WalkTrialOptions {
  std::string robot = "khr1hv";
  std::string preset = "normal";
  PathOptions path;
  PhysicsOptions physics;
  uint64_t seed = 1;
  SensorOptions sensors;
  double longest_s = 1000.0;  ///< Give up after this time.
};

struct WalkTrialResult {
  bool fell = false, finished = false;
  double fell_at_m = 0;   ///< Way of the root until then.
  double end_s = 0;       ///< Simulated time at the end.
  double distance_m = 0;  ///< Way of the root over the floor, step by step.
  double speed_m_s = 0;   ///< That way over the time between the first and the last step.
  double most_tilt_rad = 0;
  std::vector<double> path_error_m;                         ///< Distance of the root from the path, once per step.
  PlanarPose end;                                           ///< True root at the end.
  Eigen::Vector3d head_rate_rms = Eigen::Vector3d::Zero();  ///< Of the camera: roll, pitch, yaw, rad/s, while walking.
  std::vector<double> last_qpos;                            ///< To compare two runs to the bit.
  double wall_s = 0, control_wall_s = 0;
};

/// Reads a shipped robot. @throws BadInput.
Robot ReadShippedRobot(const std::string& name);

WalkTrialResult RunWalkTrial(const Robot& robot, const GaitOptions& gait, const WalkTrialOptions& options);
/// With the robot's file and its preset.
WalkTrialResult RunWalkTrial(const WalkTrialOptions& options);

}  // namespace gaitcam
