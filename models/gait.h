/// How a humanoid is asked to walk: the numbers of a step, and the path to follow.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// One gait. Robots bring presets of it (`slow`, `normal`, `brisk`); a scenario changes single fields.
struct GaitOptions {
  using DescribedTag = void;

  double step_length_m = 0.04;        ///< Forward distance between successive footprints.
  double period_s = 0.35;             ///< Duration of one step (one foot), double support included.
  double lift_m = 0.02;               ///< Height of the swing foot's sole at mid-swing.
  double double_support_ratio = 0.2;  ///< Part of the period with both feet on the floor.
  double foot_spacing_m = 0.08;       ///< Lateral distance between the ankles.
  double landing_offset_m = 0.0;  ///< Height of the swing foot's target at touch-down; negative pushes into the floor.
  double crouch_m = 0.015;        ///< Hip height given up against stretched legs.
  double servo_stiffness = 1.0;   ///< Factor on the leg servos' gains of the robot file.
  double neck_stiffness = 1.0;    ///< Factor on the neck servos' gains.
  double asymmetry_ratio = 0.0;   ///< Step length of left steps times (1 + a), of right steps times (1 - a).
  double arm_swing_rad = 0.0;     ///< Amplitude of the shoulders' counter-swing.
};

template <class Visitor>
void VisitFields(Visitor& visit, GaitOptions& o) {
  visit("step_length_m", o.step_length_m, Between(0.0, 1.0), "distance between successive footprints");
  visit("period_s", o.period_s, Between(0.1, 3.0), "duration of one step, double support included");
  visit("lift_m", o.lift_m, Between(0.001, 0.3), "height of the swing foot at mid-swing");
  visit("double_support_ratio", o.double_support_ratio, Between(0.02, 0.8), "part of the period with both feet down");
  visit("foot_spacing_m", o.foot_spacing_m, Between(0.01, 0.6), "lateral distance between the ankles");
  visit("landing_offset_m", o.landing_offset_m, Between(-0.05, 0.05), "height of the swing target at touch-down");
  visit("crouch_m", o.crouch_m, Between(0.001, 0.3), "hip height given up against stretched legs");
  visit("servo_stiffness", o.servo_stiffness, Between(0.05, 10.0), "factor on the leg servos' gains");
  visit("neck_stiffness", o.neck_stiffness, Between(0.01, 10.0), "factor on the neck servos' gains");
  visit("asymmetry_ratio", o.asymmetry_ratio, Between(-0.5, 0.5),
        "left steps longer, right steps shorter by this part");
  visit("arm_swing_rad", o.arm_swing_rad, Between(0.0, 1.5), "amplitude of the shoulders' counter-swing");
}

}  // namespace gaitcam
