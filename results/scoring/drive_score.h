/// A drive by a taught map against the truth: how near it kept to the way that it was taught, whether it reached its
/// goal, how long it took, and how near it came to people.
///
/// Everything is measured of the body's true position on the floor: X_WC of the camera, true, times the calibrated way
/// from camera to body. The taught way is where the same camera truly was on the walk that taught it.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/taught_drive.h"
#include "algorithms/core/trajectory.h"
#include "algorithms/core/units.h"
#include "results/scoring/metric.h"

namespace gaitcam {

struct DriveScoreOptions {
  using DescribedTag = void;
  double goal_m = 0.2;
  double found_m = 0.2;
  double body_radius_m = 0.22;
  double person_radius_m = 0.25;
};

template <class Visitor>
void VisitFields(Visitor& visit, DriveScoreOptions& o) {
  visit("goal_m", o.goal_m, Between(0.001, 10), "the goal is reached where the body stands so near to it");
  visit("found_m", o.found_m, Between(0.001, 10), "it knows where it is if it errs by less");
  visit("body_radius_m", o.body_radius_m, Between(0, 10), "of the robot, seen from above");
  visit("person_radius_m", o.person_radius_m, Between(0, 2), "of a person, seen from above");
}

/// Where people are, seen from above, m.
using PeopleAt = std::function<std::vector<Eigen::Vector2d>(int64_t stamp_ns)>;

/// When somebody carried the robot off.
struct CarriedSpan {
  int64_t from_ns = 0, until_ns = 0;
};

struct DriveTruth {
  const Trajectory& driven;  ///< X_WC on this run.
  const Trajectory& taught;  ///< X_WC on the walk that taught the map, same world; empty if it is not known.
  PeopleAt people;
  std::optional<CarriedSpan> carried = {};
};

/// A step of TaughtDrive::steps, as it truly was. All NaN where there is no truth.
struct DrivenStep {
  Eigen::Vector2d at_m = Eigen::Vector2d::Constant(kNaN);
  double heading_rad = kNaN;
  double moved_m = kNaN;    ///< Since the step before.
  double elapsed_s = kNaN;  ///< Likewise.
  double beside_m = kNaN;   ///< From the taught way; NaN without a route, or where the taught way is not known.
  double error_m = kNaN;    ///< Of where it believed to be; NaN where it knew nothing, or the taught way is not known.
  bool carried = false;     ///< Since the step before, in part at least: what it moved is none of its own.
  double person_m = kNaN;   ///< To the nearest person, surface to surface; NaN if there is nobody.
  std::vector<Eigen::Vector2d> people_m;  ///< Where everybody is.
};

/// The nearest that the robot and a person came, surface to surface; less than 0 is a touch.
struct Approach {
  double clearance_m = 0;
  int64_t stamp_ns = 0;
};

struct DriveComparison {
  std::vector<std::vector<Eigen::Vector2d>> taught_m;  ///< Of each route, where the body truly was when taught.
  std::vector<DrivenStep> steps;
  std::optional<CarriedSpan> carried = {};
  std::vector<std::vector<Eigen::Vector2d>> people_m;  ///< Of each person, over the drive.
  Approach nearest;                                    ///< At any time.
  Approach while_towards;                              ///< While the robot moved towards the person.
  Approach by_own_motion;     ///< Of those, while it came nearer faster than the person came to it.
  Approach in_view;           ///< Of those, where the person was in the camera's field of view.
  int touches_in_view = 0;    ///< Of the touches, where the person was in the camera's field of view.
  int touches = 0;            ///< While it moved towards the person: each counts once, until there is room again.
  std::vector<Score> scores;  ///< `drive_...`.
};

/// @throws BadOption.
DriveComparison CompareDrive(const TaughtDrive& drive, const DriveTruth& truth, const DriveScoreOptions& options = {});

struct DriveEvidence {
  const TaughtDrive& drive;
  const DriveComparison& comparison;
  const DriveScoreOptions& options;
};
std::vector<Metric<DriveEvidence>> DriveMetrics();

}  // namespace gaitcam
