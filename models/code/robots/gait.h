/// Parameters of a humanoid's gait.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// One gait. Robots bring presets of it (`slow`, `normal`, `brisk`); a scenario changes single fields.
struct GaitOptions {
  using DescribedTag = void;

  double step_length_m = 0.04;
  double period_s = 0.35;
  double lift_m = 0.02;
  double double_support_ratio = 0.2;
  double foot_spacing_m = 0.08;
  double landing_offset_m = 0.0;
  double crouch_m = 0.015;
  double servo_stiffness = 1.0;
  double neck_stiffness = 1.0;
  double asymmetry_ratio = 0.0;
  double arm_swing_rad = 0.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, GaitOptions& o) {
  visit("step_length_m", o.step_length_m, Between(0.0, 1.0), "forward distance between successive footprints");
  visit("period_s", o.period_s, Between(0.1, 3.0), "duration of one step (one foot), double support included");
  visit("lift_m", o.lift_m, Between(0.001, 0.3), "height of the swing foot's sole at mid-swing");
  visit("double_support_ratio", o.double_support_ratio, Between(0.02, 0.8),
        "part of the period with both feet on the floor");
  visit("foot_spacing_m", o.foot_spacing_m, Between(0.01, 0.6), "lateral distance between the ankles");
  visit("landing_offset_m", o.landing_offset_m, Between(-0.05, 0.05),
        "height of the swing foot's target at touch-down; negative pushes into the floor");
  visit("crouch_m", o.crouch_m, Between(0.001, 0.3), "hip height given up against stretched legs");
  visit("servo_stiffness", o.servo_stiffness, Between(0.05, 10.0), "factor on the leg servos' gains of the robot file");
  visit("neck_stiffness", o.neck_stiffness, Between(0.01, 10.0), "factor on the neck servos' gains");
  visit("asymmetry_ratio", o.asymmetry_ratio, Between(-0.5, 0.5),
        "step length of left steps times (1 + a), of right steps times (1 - a)");
  visit("arm_swing_rad", o.arm_swing_rad, Between(0.0, 1.5), "amplitude of the shoulders' counter-swing");
}

}  // namespace gaitcam
