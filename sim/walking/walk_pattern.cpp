#include "sim/walking/walk_pattern.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kRounding = 1e-9;  // of a step: a tick at a step's start belongs to that step
// Preview control starts to move the centre of mass this long before the ZMP: exp(-omega t) of the displacement, 2 %.
constexpr double kPutOff_s = 0.5;

/// From 0 to 1 with velocity and acceleration 0 at both ends.
double Quintic(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

double Mix(double a, double b, double s) { return a + (b - a) * s; }

PreviewOptions Preview(const WalkPatternOptions& options) {
  PreviewOptions preview;
  preview.period_s = options.control_period_s;
  preview.com_height_m = options.com_height_m;
  preview.horizon_s = options.preview_s;
  return preview;
}

}  // namespace

WalkPattern::WalkPattern(const GaitOptions& gait, const WalkPatternOptions& options, FootstepPlanner planner)
    : gait_(gait),
      options_(options),
      planner_(std::move(planner)),
      preview_(Preview(options)),
      rested_(planner_),
      begin_s_(options.settle_s) {
  preview_.Reset(RestZmp(1));
  AppendPrints(-1, {});
  FillReference();
  PlaceFeet(-1, 0);
  targets_.posture.com = targets_.dcm = preview_.position();
  targets_.acceleration.setZero();
}

/// Fills the preview window from the next tick on: Advance() drops the first value and appends one.
void WalkPattern::FillReference() {
  reference_.clear();
  for (int j = 0; j < preview_.reference_count(); ++j) {
    reference_.push_back(ZmpAt(double(tick_ + j) * options_.control_period_s));
  }
}

void WalkPattern::Halt() {
  halted_ = true;
  if (time() > begin_s_ - kPutOff_s) {
    planner_.Halt();
    return;
  }
  planner_ = rested_;
  planner_.End();
  begin_s_ = std::numeric_limits<double>::infinity();
  FillReference();
}

bool WalkPattern::Halted() const {
  return halted_ && planner_.ended() && (std::isinf(begin_s_) || StepAt(time()) >= StepCount());
}

void WalkPattern::GoOn(const PlanDrift& drift) {
  GAITCAM_ASSERT(Halted());
  planner_.GoOn();
  Resume(drift);
}

void WalkPattern::FollowPath(const PlanDrift& drift) {
  GAITCAM_ASSERT(Halted());
  planner_.FollowPath(drift);
  Resume(drift);
}

void WalkPattern::Walk(const Velocity& velocity, const PlanDrift& drift) {
  GAITCAM_ASSERT(Halted());
  planner_.Walk(velocity);
  Resume(drift);
}

void WalkPattern::GoTo(const PlanarPose& goal, const PlanDrift& drift) {
  GAITCAM_ASSERT(Halted());
  planner_.GoTo(goal, drift);
  Resume(drift);
}

void WalkPattern::Resume(const PlanDrift& drift) {
  halted_ = false;
  if (!planner_.ended()) BeginStretch(drift);
}

void WalkPattern::TurnOnTheSpot(double turn_rad, const PlanDrift& drift) {
  GAITCAM_ASSERT(Halted());
  planner_.TurnOnTheSpot(turn_rad, drift);
  BeginStretch(drift);
}

void WalkPattern::BeginStretch(const PlanDrift& drift) {
  rested_ = planner_;
  first_step_ = planner_.count() - 2;
  begin_s_ = time() + options_.preview_s + options_.control_period_s;
  AppendPrints(first_step_ - 1, drift);
}

const WalkTargets& WalkPattern::Advance(const PlanDrift& drift) {
  const int before = StepAt(time());
  ++tick_;
  const int step = StepAt(time());
  if (step != before) AppendPrints(step, drift);

  // Prints never change once they are appended, so each tick appends one reference value at the horizon's end.
  reference_.erase(reference_.begin());
  reference_.push_back(ZmpAt(time() + (preview_.reference_count() - 1) * options_.control_period_s));
  preview_.Update(reference_);
  targets_.posture.com = preview_.position();
  targets_.dcm = preview_.Dcm();
  targets_.acceleration = preview_.acceleration();
  PlaceFeet(step, PhaseAt(time(), step));
  return targets_;
}

int WalkPattern::StepAt(double time) const {
  if (time < begin_s_) return first_step_ - 1;
  return std::min(first_step_ + int(std::floor((time - begin_s_) / gait_.period_s + kRounding)), StepCount());
}

/// How far into `step`, in steps.
double WalkPattern::PhaseAt(double time, int step) const {
  return (time - begin_s_) / gait_.period_s - (step - first_step_);
}

bool WalkPattern::Finished() const {
  if (halted_ || !planner_.complete()) return false;
  return time() >= begin_s_ + options_.settle_s + (StepCount() - first_step_) * gait_.period_s;
}

void WalkPattern::AppendPrints(int step, const PlanDrift& drift) {
  planner_.Forget(std::max(0, step));
  const int ahead = 3 + int(std::floor(options_.preview_s / gait_.period_s + kRounding));
  while (!planner_.ended() && planner_.count() < step + ahead + 1) planner_.Append(drift, step);
}

Eigen::Vector2d WalkPattern::SupportZmp(int print) const {
  const Footprint& p = planner_.print(print);
  return p.ankle * Eigen::Vector2d(options_.zmp_forward_m, -SideSign(p.side) * options_.zmp_inward_m);
}

Eigen::Vector2d WalkPattern::RestZmp(int print) const { return 0.5 * (SupportZmp(print - 1) + SupportZmp(print)); }

Eigen::Vector2d WalkPattern::ZmpAt(double time) const {
  const int step = StepAt(time);
  if (step < first_step_) return RestZmp(first_step_ + 1);
  const bool stopped = step == StepCount();
  const Eigen::Vector2d from = step == first_step_ ? RestZmp(step + 1) : SupportZmp(step);
  const Eigen::Vector2d to = stopped ? RestZmp(step + 1) : SupportZmp(step + 1);
  const double since = time - begin_s_ - (step - first_step_) * gait_.period_s;
  return from + (to - from) * std::clamp(since / (gait_.double_support_ratio * gait_.period_s), 0.0, 1.0);
}

void WalkPattern::PlaceFeet(int step, double phase) {
  const bool standing = step < first_step_ || step >= StepCount();
  const int stance_print = std::max(step, first_step_) + 1;  // standing: the later of the two prints
  const Footprint& stance = planner_.print(stance_print);
  const Footprint& other = planner_.print(stance_print - 1);
  const auto on_floor = [&](const Footprint& p) { return p.ankle.Lifted(options_.ankle_height_m); };
  targets_.posture.X_PA[stance.side] = on_floor(stance);
  targets_.posture.X_PA[other.side] = on_floor(other);
  targets_.posture.heading = 0.5 * (stance.ankle.heading + other.ankle.heading);
  targets_.swing_phase = 0;
  targets_.stance = -1;
  targets_.load = {0.5, 0.5};
  targets_.gait = {};
  if (standing) {
    // After the last step the stance foot hands over half of the weight to the foot that has just landed.
    if (step > first_step_)
      targets_.load[other.side] = Mix(1, 0.5, std::clamp(phase / gait_.double_support_ratio, 0.0, 1.0));
    targets_.load[stance.side] = 1 - targets_.load[other.side];
    return;
  }

  targets_.stance = stance.side;
  targets_.gait.step = step;
  targets_.gait.phase = std::clamp(phase, 0.0, 1.0);
  const double single_begin = gait_.double_support_ratio;
  if (phase < single_begin) {
    const double moved = phase / single_begin;  // as the planned ZMP does
    targets_.load[stance.side] = step == first_step_ ? Mix(0.5, 1, moved) : moved;
    targets_.load[other.side] = 1 - targets_.load[stance.side];
    if (step > first_step_) {  // return the foot's target from its landing offset to the floor
      targets_.posture.X_PA[stance.side].translation.z() +=
          gait_.landing_offset_m * (1 - Quintic(phase / single_begin));
    }
  } else {
    targets_.load[stance.side] = 1;
    targets_.load[other.side] = 0;
    targets_.gait.support = stance.side == 0 ? SupportPhase::kLeft : SupportPhase::kRight;
    targets_.swing_phase = (phase - single_begin) / (1 - single_begin);
    PlaceSwingFoot(step, targets_.swing_phase);
  }
  const double next_heading = 0.5 * (stance.ankle.heading + planner_.print(step + 2).ankle.heading);
  targets_.posture.heading = Mix(targets_.posture.heading, next_heading, Quintic(phase));
}

void WalkPattern::PlaceSwingFoot(int step, double swing_phase) {
  const Footprint& from = planner_.print(step);
  const Footprint& to = planner_.print(step + 2);
  const double moved = Quintic(swing_phase / options_.landing_phase);
  const double height = swing_phase < 0.5 ? gait_.lift_m * Quintic(2 * swing_phase)
                                          : Mix(gait_.lift_m, gait_.landing_offset_m, Quintic(2 * swing_phase - 1));
  const PlanarPose ankle(from.ankle.position + moved * (to.ankle.position - from.ankle.position),
                         Mix(from.ankle.heading, to.ankle.heading, moved));
  targets_.posture.X_PA[from.side] = ankle.Lifted(options_.ankle_height_m + height);
}

}  // namespace gaitcam
