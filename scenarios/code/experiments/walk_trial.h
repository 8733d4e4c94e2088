/// One walk without cameras: physics, noisy sensors and a controller, for tests and the experiment about walking.

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/planar_pose.h"
#include "models/code/robots/robot.h"
#include "sim/sensors/sensors.h"
#include "sim/walking/path.h"
#include "sim/world/world.h"

namespace gaitcam {

struct WalkTrialOptions {
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
  double max_tilt_rad = 0;
  std::vector<double> path_error_m;                         ///< Distance of the root from the path, once per step.
  PlanarPose start, end;                                    ///< True root at first and at the end.
  std::vector<OdometrySample> odometry;                     ///< Of the legs, if the sensors have it.
  Eigen::Vector3d head_rate_rms = Eigen::Vector3d::Zero();  ///< Of the camera: roll, pitch, yaw, rad/s, while walking.
  Eigen::Vector2d head_tilt_rms = Eigen::Vector2d::Zero();  ///< Of the camera, about how it stood: roll, pitch; rad.
  double head_height_rms_m = 0;                             ///< Likewise of its height.
  std::vector<double> last_qpos;                            ///< To compare two runs to the bit.
  double wall_s = 0, control_wall_s = 0;
};

WalkTrialResult RunWalkTrial(const Robot& robot, const GaitOptions& gait, const WalkTrialOptions& options);

}  // namespace gaitcam
