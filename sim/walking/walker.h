/// A humanoid's walking controller: from sensor readings to servo targets.
///
/// Each control tick: estimate the attitude and the centre of mass from IMU and encoders; advance the plan (footprints,
/// preview control); shift the planned centre of mass against the error of the divergent component of motion; solve the
/// legs; tilt the ankles against the trunk's tilt. Forces reach the robot through its servos and the floor alone.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "models/code/robots/robot.h"
#include "sim/walking/controller.h"
#include "sim/walking/path.h"
#include "sim/world/world.h"

namespace gaitcam {

/// Gains of the feedback; a robot's file overrides them under `control:`.
struct WalkerOptions {
  using DescribedTag = void;

  double roll_gain = 0.3;
  double roll_rate_gain = 0.03;
  double pitch_gain = 0.3;
  double pitch_rate_gain = 0.03;
  double leveling_gain = 0.5;
  double dcm_gain = 0.3;
  double dcm_filter_s = 0.05;
  double dcm_limit_m = 0.02;
  double feedforward = 1.0;
  double attitude_gain = 0.2;
  double velocity_filter_s = 0.01;
  double zmp_forward_m = 0;
  double zmp_inward_m = 0;
  double lean_rad = 0;
  double preview_s = 1.0;
  double landing_phase = 0.95;
  double max_turn_rad = 0.25;
  double heading_gain = 0.3;
  double offset_gain = 2.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, WalkerOptions& o) {
  visit("roll_gain", o.roll_gain, Between(0, 5), "stance ankle roll per trunk roll");
  visit("roll_rate_gain", o.roll_rate_gain, Between(0, 1), "stance ankle roll per roll rate, s");
  visit("pitch_gain", o.pitch_gain, Between(0, 5), "stance ankle pitch per trunk pitch");
  visit("pitch_rate_gain", o.pitch_rate_gain, Between(0, 1), "stance ankle pitch per pitch rate, s");
  visit("leveling_gain", o.leveling_gain, Between(0, 1),
        "part of the trunk's tilt that the swing foot's ankle takes back");
  visit("dcm_gain", o.dcm_gain, Between(0, 5),
        "shift of the centre of mass per error of the divergent component of motion (DCM)");
  visit("dcm_filter_s", o.dcm_filter_s, Between(0.001, 1), "time constant of the low-pass of the DCM shift");
  visit("dcm_limit_m", o.dcm_limit_m, Between(0, 0.2), "upper limit of the DCM shift");
  visit("feedforward", o.feedforward, Between(0, 1),
        "share of the known loads and speeds that is added to the servos' targets");
  visit("attitude_gain", o.attitude_gain, Between(0, 20),
        "rate at which the accelerometer corrects the gyroscope, 1/s");
  visit("velocity_filter_s", o.velocity_filter_s, Between(0, 0.5),
        "time constant of the low-pass of the measured velocity of the centre of mass");
  visit("zmp_forward_m", o.zmp_forward_m, Between(-0.2, 0.2), "planned ZMP forward of the sole's middle");
  visit("zmp_inward_m", o.zmp_inward_m, Between(-0.2, 0.2), "planned ZMP from the ankle towards the other foot");
  visit("lean_rad", o.lean_rad, Between(-0.5, 0.5), "the trunk's pitch");
  visit("preview_s", o.preview_s, Between(0.2, 3), "horizon of the preview control");
  visit("landing_phase", o.landing_phase, Between(0.5, 1),
        "part of the swing after which the foot no longer moves horizontally");
  visit("max_turn_rad", o.max_turn_rad, Between(0.01, 0.8), "upper limit of one step's turn");
  visit("heading_gain", o.heading_gain, Between(0, 1), "part of the heading error that one step takes away");
  visit("offset_gain", o.offset_gain, Between(0, 20), "heading back to the path, rad per m beside it");
}

/// The defaults, overridden by what the robot's file says under `control:`.
/// @throws BadInput naming the robot's file and an unknown key (and the nearest known one), BadOption for a value.
WalkerOptions ReadWalkerOptions(const Robot& robot);

/// Why a gait cannot be walked by a robot on a path, found by planning its steps without physics.
/// @throws BadOption naming the parameter, its value and the limit ("gait.step_length_m: 0.2 exceeds 0.11, ...").
void CheckGait(const Robot& robot, const mjModel* nominal, const GaitOptions& gait, const PathOptions& path,
               const PhysicsOptions& physics);

/// A walking controller that starts at `start` (x, y and yaw count).
/// @param nominal the model whose masses the controller believes in; must outlive the controller.
/// @throws BadOption or BadInput if the robot cannot walk like that: see CheckGait and LegKinematics.
std::unique_ptr<Controller> MakeWalker(const Robot& robot, const mjModel* nominal, const GaitOptions& gait,
                                       const PathOptions& path, const PhysicsOptions& physics, const Pose& start);

/// Time that a walker needs for its path, s; nearly exact but for what steering adds.
double EstimateWalkingTime(const GaitOptions& gait, const PathOptions& path);

}  // namespace gaitcam
