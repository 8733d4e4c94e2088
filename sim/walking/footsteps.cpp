#include "sim/walking/footsteps.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr double kArrived_m = 0.002;
constexpr double kTurned_rad = 0.01;

/// The longest step from which steps that shrink by `ramp` each still stop within `distance`.
double LongestStoppableStep(double distance, double ramp) {
  // l + (l - r) + (l - 2 r) + ... = l (l + r) / (2 r)
  const double length = 0.5 * (std::sqrt(ramp * ramp + 8 * ramp * distance) - ramp);
  return std::min(length, distance);
}

}  // namespace

FootstepPlanner::FootstepPlanner(const GaitOptions& gait, const SteeringOptions& steering, const Path& path)
    : gait_(gait), steering_(steering), path_{path} {
  for (const int side : {0, 1}) {
    const PlanarPose beside({0, SideSign(side) * gait.foot_spacing_m / 2}, 0);
    prints_.push_back({side, path.start() * beside});
  }
  path_.complete = ended_ = path.segments().empty();
}

void FootstepPlanner::Halt() { halting_ = true; }

void FootstepPlanner::GoOn() {
  GAITCAM_ASSERT(ended_);
  ended_ = !velocity_ && route().complete;
  halting_ = false;
  length_m_ = 0;
  spot_heading_.reset();
}

void FootstepPlanner::FollowPath(const PlanDrift& drift) {
  velocity_.reset();
  goal_.reset();
  GoOn();
  if (path_.complete) return;
  const double off =
      (drift.X_WP * Center(prints_.back())).heading - path_.path.segments()[path_.segment].At(path_.along).heading;
  path_.turns_rad = 2 * kPi * std::round(off / (2 * kPi));
}

void FootstepPlanner::Walk(const Velocity& velocity) {
  goal_.reset();
  velocity_ = velocity;
  if (ended_) GoOn();
}

void FootstepPlanner::GoTo(const PlanarPose& goal, const PlanDrift& drift) {
  velocity_.reset();
  goal_.emplace(Route{Path::ToGoal(drift.X_WP * Center(prints_.back()), goal)});
  goal_->complete = goal_->path.segments().empty();
  GoOn();
}

void FootstepPlanner::TurnOnTheSpot(double turn_rad, const PlanDrift& drift) {
  GAITCAM_ASSERT(ended_);
  ended_ = false;
  length_m_ = 0;
  spot_heading_ = (drift.X_WP * Center(prints_.back())).heading + turn_rad;
}

const Footprint& FootstepPlanner::print(int index) const {
  GAITCAM_ASSERT(index >= forgotten_ && index < count());
  return prints_[size_t(index - forgotten_)];
}

void FootstepPlanner::Forget(int index) {
  while (forgotten_ < index && prints_.size() > 2) {
    prints_.pop_front();
    ++forgotten_;
  }
}

PlanarPose FootstepPlanner::Center(const Footprint& print) const {
  return print.ankle * PlanarPose({0, -SideSign(print.side) * gait_.foot_spacing_m / 2}, 0);
}

void FootstepPlanner::Append(const PlanDrift& drift, int standing) {
  GAITCAM_ASSERT(!ended_);
  const PlanarPose center = Center(prints_.back());
  const Advance advance = Next(PredictCenter(drift, standing), drift.slip_rad);
  const int side = 1 - prints_.back().side;
  const double length = advance.length_m * (1 + SideSign(side) * gait_.asymmetry_ratio);
  // The way to the next centre is an arc's chord: it leaves in the direction of half the turn.
  const PlanarPose chord({0, 0}, advance.turn_rad / 2);
  const PlanarPose next = center * chord * PlanarPose({length, advance.left_m}, 0) * chord;
  prints_.push_back({side, next * PlanarPose({0, SideSign(side) * gait_.foot_spacing_m / 2}, 0)});
  length_m_ = advance.length_m;
}

PlanarPose FootstepPlanner::PredictCenter(const PlanDrift& drift, int standing) const {
  const PlanarPose X_WC = drift.X_WP * Center(prints_.back());
  // Turned by the slip at each pending step, the way there bends: length times slip times 0 + 1 + 2 + ...
  const double pending = std::max(0, count() - 1 - standing);
  const double sideways = 0.5 * pending * (pending - 1) * length_m_ * drift.slip_rad;
  return X_WC * PlanarPose({0, sideways}, pending * drift.slip_rad);
}

FootstepPlanner::Advance FootstepPlanner::Next(const PlanarPose& X_WC, double slip_rad) {
  if (spot_heading_) {
    ended_ = std::abs(*spot_heading_ - X_WC.heading) < kTurned_rad;
    return ended_ ? Advance() : TowardsHeading(*spot_heading_, X_WC, slip_rad);
  }
  const Advance advance = velocity_ ? AtVelocity(slip_rad) : AlongRoute(route(), X_WC, slip_rad);
  // Steps that shrink by a ramp each come down to nothing: feet side by side.
  const bool halted = halting_ && std::abs(advance.length_m) < 0.5 * steering_.ramp_ratio * gait_.step_length_m;
  ended_ = (!velocity_ && route().complete) || halted;
  return ended_ ? Advance() : advance;
}

FootstepPlanner::Advance FootstepPlanner::AtVelocity(double slip_rad) const {
  const double full = gait_.step_length_m, ramp = steering_.ramp_ratio * full, step_s = gait_.period_s;
  const double widest = steering_.side_ratio * gait_.foot_spacing_m;
  // A side step is made by every second foot alone, the outer one, hence twice as wide.
  double length = halting_ ? 0 : velocity_->forward_mps * step_s,
         left = halting_ ? 0 : 2 * velocity_->left_mps * step_s;
  const double longest = length < 0 ? steering_.backward_ratio * full : full;
  const double effort = std::abs(length) / longest + std::abs(left) / widest;
  if (effort > 1) length /= effort, left /= effort;
  Advance advance;
  advance.length_m = std::clamp(length, length_m_ - ramp, length_m_ + ramp);
  const int next_side = 1 - prints_.back().side;
  if (left * SideSign(next_side) > 0) advance.left_m = left;
  const double turn = halting_ ? 0 : velocity_->turn_rad_s * step_s;
  advance.turn_rad = std::clamp(turn - slip_rad, -steering_.max_turn_rad, steering_.max_turn_rad);
  return advance;
}

FootstepPlanner::Advance FootstepPlanner::TowardsHeading(double heading, const PlanarPose& X_WC,
                                                         double slip_rad) const {
  const double left_to_turn = heading - X_WC.heading;
  return {0, std::clamp(left_to_turn - slip_rad, -steering_.max_turn_rad, steering_.max_turn_rad)};
}

FootstepPlanner::Advance FootstepPlanner::AlongRoute(Route& route, PlanarPose X_WC, double slip_rad) {
  X_WC.heading -= route.turns_rad;
  for (; route.segment < route.path.segments().size(); ++route.segment, route.along = 0) {
    const PathSegment& segment = route.path.segments()[route.segment];
    if (segment.IsTurnOnTheSpot()) {
      const double heading = segment.start.heading + segment.turn_rad;
      if (std::abs(heading - X_WC.heading) < kTurned_rad) continue;
      return TowardsHeading(heading, X_WC, slip_rad);
    }
    const PathSegment::Location location = segment.Locate(X_WC.position, route.along);
    route.along = location.along;
    if (route.along >= segment.length_m || DistanceToStop(route) < kArrived_m) continue;
    Advance advance = AlongSegment(segment, X_WC, location.along, location.left);
    advance.turn_rad = std::clamp(advance.turn_rad - slip_rad, -steering_.max_turn_rad, steering_.max_turn_rad);
    return advance;
  }
  route.complete = true;
  return {};
}

double FootstepPlanner::DistanceToStop(const Route& route) {
  const std::vector<PathSegment>& segments = route.path.segments();
  double distance = -route.along;
  for (size_t i = route.segment; i < segments.size() && !segments[i].IsTurnOnTheSpot(); ++i) {
    distance += segments[i].length_m;
  }
  return distance;
}

FootstepPlanner::Advance FootstepPlanner::AlongSegment(const PathSegment& segment, const PlanarPose& X_WC, double along,
                                                       double left) const {
  const double full = gait_.step_length_m;
  const double ramp = steering_.ramp_ratio * full;
  const double most = halting_ ? std::max(0.0, length_m_ - ramp) : length_m_ + ramp;
  const double length = std::min({full, most, LongestStoppableStep(DistanceToStop(route()), ramp)});
  const double approach =
      std::clamp(steering_.offset_gain * left, -steering_.max_approach_rad, steering_.max_approach_rad);
  const double heading_error = segment.At(along).heading - approach - X_WC.heading;
  return {length, segment.Curvature() * length + steering_.heading_gain * heading_error};
}

}  // namespace gaitcam
