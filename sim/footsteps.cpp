#include "sim/footsteps.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

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
    : gait_(gait), steering_(steering), path_(path) {
  for (const int side : {0, 1}) {
    const PlanarPose beside({0, SideSign(side) * gait.foot_spacing_m / 2}, 0);
    prints_.push_back({side, path.start() * beside});
  }
  complete_ = ended_ = path.segments().empty();
}

void FootstepPlanner::Halt() { halting_ = true; }

void FootstepPlanner::GoOn() {
  GAITCAM_ASSERT(ended_);
  ended_ = complete_;
  halting_ = false;
  length_m_ = 0;
  spot_heading_.reset();
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
  const PlanarPose next = center * chord * PlanarPose({length, 0}, 0) * chord;
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
  const Advance advance = AlongPath(X_WC, slip_rad);
  // Steps that shrink by a ramp each come down to nothing: feet side by side.
  const bool halted = halting_ && advance.length_m < 0.5 * steering_.ramp_ratio * gait_.step_length_m;
  ended_ = complete_ || halted;
  return ended_ ? Advance() : advance;
}

FootstepPlanner::Advance FootstepPlanner::TowardsHeading(double heading, const PlanarPose& X_WC,
                                                         double slip_rad) const {
  const double left_to_turn = heading - X_WC.heading;
  return {0, std::clamp(left_to_turn - slip_rad, -steering_.max_turn_rad, steering_.max_turn_rad)};
}

FootstepPlanner::Advance FootstepPlanner::AlongPath(const PlanarPose& X_WC, double slip_rad) {
  for (; segment_ < path_.segments().size(); ++segment_, along_ = 0) {
    const PathSegment& segment = path_.segments()[segment_];
    if (segment.IsTurnOnTheSpot()) {
      const double heading = segment.start.heading + segment.turn_rad;
      if (std::abs(heading - X_WC.heading) < kTurned_rad) continue;
      return TowardsHeading(heading, X_WC, slip_rad);
    }
    const PathSegment::Location location = segment.Locate(X_WC.position, along_);
    along_ = location.along;
    if (along_ >= segment.length_m || DistanceToStop(along_) < kArrived_m) continue;
    Advance advance = AlongSegment(segment, X_WC, location.along, location.left);
    advance.turn_rad = std::clamp(advance.turn_rad - slip_rad, -steering_.max_turn_rad, steering_.max_turn_rad);
    return advance;
  }
  complete_ = true;
  return {};
}

double FootstepPlanner::DistanceToStop(double along) const {
  double distance = -along;
  for (size_t i = segment_; i < path_.segments().size() && !path_.segments()[i].IsTurnOnTheSpot(); ++i) {
    distance += path_.segments()[i].length_m;
  }
  return distance;
}

FootstepPlanner::Advance FootstepPlanner::AlongSegment(const PathSegment& segment, const PlanarPose& X_WC, double along,
                                                       double left) const {
  const double full = gait_.step_length_m;
  const double ramp = steering_.ramp_ratio * full;
  const double most = halting_ ? std::max(0.0, length_m_ - ramp) : length_m_ + ramp;
  const double length = std::min({full, most, LongestStoppableStep(DistanceToStop(along), ramp)});
  const double approach =
      std::clamp(steering_.offset_gain * left, -steering_.max_approach_rad, steering_.max_approach_rad);
  const double heading_error = segment.At(along).heading - approach - X_WC.heading;
  return {length, segment.Curvature() * length + steering_.heading_gain * heading_error};
}

}  // namespace gaitcam
