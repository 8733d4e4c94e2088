/// Drives an omnidirectional base along a path: the control group of every gait study.
///
/// The base follows the path's reference pose by arc length with smooth speed ramps, and stops to turn on the spot. Its
/// drive is a position servo on x, y and yaw (see Robot::drive), so `path.feedback` makes no difference to it. A base
/// that stands for somebody who walks moves its hand with the steps (hand_sway.h).

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "algorithms/core/fields.h"
#include "models/code/robots/robot.h"
#include "sim/walking/controller.h"
#include "sim/walking/path.h"
#include "sim/walking/smooth_profile.h"

namespace gaitcam {

struct OmniDriveOptions {
  using DescribedTag = void;

  double speed_mps = 0.2;
  double acceleration_mps2 = 0.3;
  double turn_rate_rad_s = 0.6;
  double turn_acceleration_rad_s2 = 1.0;
  double vibration_amplitude_rad = 0;
  double vibration_hz = 8;
};

template <class Visitor>
void VisitFields(Visitor& visit, OmniDriveOptions& o) {
  visit("speed_mps", o.speed_mps, Between(0.01, 3.0), "along the path");
  visit("acceleration_mps2", o.acceleration_mps2, Between(0.01, 10.0),
        "upper limit along the path, m/s^2; speed ramps are raised cosines");
  visit("turn_rate_rad_s", o.turn_rate_rad_s, Between(0.01, 6.0), "of turns on the spot");
  visit("turn_acceleration_rad_s2", o.turn_acceleration_rad_s2, Between(0.01, 50.0),
        "upper limit of turns on the spot");
  visit("vibration_amplitude_rad", o.vibration_amplitude_rad, Between(0.0, 0.1), "of pitch and roll at full speed");
  visit("vibration_hz", o.vibration_hz, Between(0.5, 50.0), "of pitch; roll shakes 0.83 times as fast");
}

/// Time to drive the path, standing still before and after included, s.
double EstimateDrivingTime(const OmniDriveOptions& options, const PathOptions& path);

/// Where the base is along its path at a time of the run, s, if it is never commanded. @throws BadOption for a field
/// out of range.
std::function<PlanarPose(double time_s)> PlanDriving(const OmniDriveOptions& options, const PathOptions& path,
                                                     const Pose& start);

/// A controller that starts at `start` (x, y and yaw count). Its targets are the joints of the robot, then x, y, yaw,
/// pitch and roll of the base, as World::SetTargets expects them.
/// @param seed of how a carried base sways (Robot::sway). @throws BadOption for a field out of range.
std::unique_ptr<Controller> MakeOmniDrive(const Robot& robot, const OmniDriveOptions& options, const PathOptions& path,
                                          const Pose& start, uint64_t seed = 1);

}  // namespace gaitcam
