/// Footsteps of people: where and when a foot lands, along a course that says where the body is to be.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/units.h"
#include "models/code/people/people.h"

namespace gaitcam {

constexpr double kUsualHeight_m = 1.75;              ///< Of people whose steps were measured.
constexpr double kHipsLead_s = 0.045;                ///< In walking, the hips are so much ahead of the feet's middle.
constexpr double kMostTurnOfStep = 50 * kRadPerDeg;  ///< Of a foot against the other one, rad.

/// Where a foot stands: the spot under the hips that it belongs to.
struct FootSpot {
  Eigen::Vector2d spot{0, 0};
  double yaw = 0;
};

/// One foot goes from one print to the next, or (side -1) none does for a while.
struct PersonStep {
  double begin_s = 0, duration_s = 0;
  int side = 0;  ///< 0 left, 1 right.
  FootSpot from, to;
};

/// How long steps are of somebody who walks as he likes, m.
double StepLength(double speed_m_s, double height_m);

/// Steps and pauses, one after the other from the course's begin to its end, that carry the hips along a course. Steps
/// are as long as its speed asks for; who hardly moves stands until there is a step to do. Feet do not cross.
/// `begin_s` counts from the course's begin. @param begun steps that are done or on their way, and stay as they are.
/// @pre the course has a pose.
std::vector<PersonStep> StepsAlong(const PersonCourse& course, double height_m, std::vector<PersonStep> begun = {});

/// The steps that have begun at `time_s`. A pause of somebody who stands at ease ends then.
std::vector<PersonStep> StepsBegun(std::vector<PersonStep> steps, double time_s);

}  // namespace gaitcam
