/// Footprints along a path: where the next foot goes, given where the robot is believed to be.
///
/// Footprints live in the plan's frame P: the floor as the feet would find it if no step ever slipped. P starts as the
/// world W; while slipping feet carry it away, X_WP says how P lies in W. The queue of footprints is longer than what
/// is walked, since preview control looks ahead. So steering does not ask where the robot is, but where the last
/// footprint of the queue will be, X_WP * print, slip to come included: otherwise every correction would come again, a
/// queue's length too late.

#pragma once

#include <deque>
#include <optional>

#include "algorithms/core/body_command.h"
#include "models/code/robots/gait.h"
#include "sim/walking/path.h"

namespace gaitcam {

/// `side` is 0 for left, 1 for right; the pose is that of the ankle, projected on the floor.
struct Footprint {
  int side = 0;
  PlanarPose ankle;
};

/// +1 for the left foot, -1 for the right: the sign of its y.
inline double SideSign(int side) { return side == 0 ? 1.0 : -1.0; }

/// How the plan lies in the world, as last seen.
struct PlanDrift {
  PlanarPose X_WP;
  double slip_rad = 0;  ///< By how much P turns in W from step to step: feet slip in the same way again and again.
};

struct SteeringOptions {
  double max_turn_rad = 0.25;     ///< Most that one step turns.
  double heading_gain = 0.3;      ///< Part of the heading error that one step takes away.
  double offset_gain = 1.0;       ///< rad of heading per m beside the path.
  double max_approach_rad = 0.5;  ///< Most that the heading leaves the path's to come back to it.
  double ramp_ratio = 0.25;       ///< Most that the step length changes from step to step, in step lengths.
  double backward_ratio = 0.5;    ///< Longest backward step of a commanded velocity, in step lengths.
  double side_ratio = 0.3;        ///< Widest outward step of a commanded velocity, in foot spacings.
};

class FootstepPlanner {
 public:
  /// Stands on both feet at the path's start; print 0 is the left foot's, print 1 the right foot's.
  FootstepPlanner(const GaitOptions& gait, const SteeringOptions& steering, const Path& path);

  /// Footprint `index`, alternately left and right. @pre it was appended and not forgotten.
  const Footprint& print(int index) const;
  /// Number of prints appended so far, forgotten ones included.
  int count() const { return forgotten_ + int(prints_.size()); }
  /// The last print has been appended: the feet stand side by side at the path's end.
  bool complete() const { return path_.complete && !goal_ && !velocity_; }
  /// No footprint is to be appended for now: path or goal is reached, or halted; the feet stand side by side.
  bool ended() const { return ended_; }

  /// Shrinks the steps to come and ends them as soon as that allows, until GoOn() or TurnOnTheSpot().
  void Halt();
  /// Ends them now. @pre the feet stand side by side.
  void End() { ended_ = true; }
  /// Goes on with what was done before Halt() or TurnOnTheSpot(), from where the last footprint is. @pre ended.
  void GoOn();
  /// Follows the path again, from where it was left. @pre ended. @param drift as now seen.
  void FollowPath(const PlanDrift& drift);
  /// Walks at constant velocity, clamped to what steps can be: forward and sideways share the longest step, only the
  /// outer foot steps sideways. @pre ended, or walking at another velocity.
  void Walk(const Velocity& velocity);
  /// Leaves the path for a goal in W, and ends there. @pre ended. @param drift as now seen.
  void GoTo(const PlanarPose& goal, const PlanDrift& drift);
  /// Leaves the path to turn where it stands, and ends. @pre ended. @param drift as now seen.
  void TurnOnTheSpot(double turn_rad, const PlanDrift& drift);

  /// Appends the next footprint. @pre not ended.
  /// @param drift as seen while print `standing` carried the robot; between that and the last print, it goes on.
  void Append(const PlanDrift& drift, int standing);
  /// Drops the prints before `index`, so that a long walk does not grow.
  void Forget(int index);

  /// Midway between where this print's foot and the other one stand.
  PlanarPose Center(const Footprint& print) const;

 private:
  struct Advance {
    double length_m = 0, turn_rad = 0, left_m = 0;
  };
  /// A path and where on it the last footprint is.
  struct Route {
    Path path;
    size_t segment = 0;
    double along = 0;  ///< On that segment, m.
    bool complete = false;
    double turns_rad = 0;  ///< Whole turns that the robot has made more than the path, since it left it.
  };
  Route& route() { return goal_ ? *goal_ : path_; }
  const Route& route() const { return goal_ ? *goal_ : path_; }
  Advance AtVelocity(double slip_rad) const;
  PlanarPose PredictCenter(const PlanDrift& drift, int standing) const;
  Advance Next(const PlanarPose& X_WC, double slip_rad);
  Advance TowardsHeading(double heading, const PlanarPose& X_WC, double slip_rad) const;
  Advance AlongRoute(Route& route, PlanarPose X_WC, double slip_rad);
  Advance AlongSegment(const PathSegment& segment, const PlanarPose& X_WC, double along, double left) const;
  static double DistanceToStop(const Route& route);

  GaitOptions gait_;
  SteeringOptions steering_;
  Route path_;
  std::optional<Route> goal_;         ///< Followed instead of the path.
  std::optional<Velocity> velocity_;  ///< Walked instead of following anything.
  std::deque<Footprint> prints_;
  int forgotten_ = 0;
  double length_m_ = 0;  ///< Of the last step.
  bool ended_ = false, halting_ = false;
  std::optional<double> spot_heading_;  ///< Where a turn beside the path leads, rad in W.
};

}  // namespace gaitcam
