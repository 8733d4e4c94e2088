/// The timed walking pattern: from footprints to references for feet, root and centre of mass at each control tick.
///
/// Step k stands on print k + 1 while the other foot swings from print k to print k + 2. It begins with both feet down,
/// while the planned ZMP moves from the old support to the new one. The robot
/// stands on both feet before the first step, after the last one, and where it was halted; after a halt a new stretch
/// of steps begins, whose first step k again stands on print k + 1.

#pragma once

#include <array>
#include <vector>

#include "sim/walking/controller.h"
#include "sim/walking/footsteps.h"
#include "sim/walking/posture.h"
#include "sim/walking/preview_control.h"

namespace gaitcam {

struct WalkPatternOptions {
  double control_period_s = 0.004;
  double settle_s = 1.0;  ///< Standing before the first and after the last step.
  double preview_s = 1.0;
  double landing_phase = 0.95;   ///< Part of the swing after which the foot no longer moves horizontally.
  double zmp_forward_m = 0.008;  ///< Planned ZMP of a single support, from the ankle.
  double zmp_inward_m = 0;       ///< Likewise, towards the other foot.
  double ankle_height_m = 0.03;
  double com_height_m = 0.157;
};

struct WalkTargets {
  Posture::Targets posture;  ///< Feet, heading and centre of mass, in the plan's frame.
  Eigen::Vector2d dcm;       ///< The matching divergent component of motion, m.
  GaitState gait;
  int stance = -1;                       ///< Side that carries the step, 0 or 1; -1 while standing.
  std::array<double, 2> load{0.5, 0.5};  ///< Planned share of the weight on each foot.
  Eigen::Vector2d acceleration;          ///< Of the centre of mass, m/s^2.
  double swing_phase = 0;                ///< 0 during double support, then 0..1.
};

class WalkPattern {
 public:
  WalkPattern(const GaitOptions& gait, const WalkPatternOptions& options, FootstepPlanner planner);

  /// Advances by one control period. @param drift of the plan's frame in the world; used when a step is
  /// appended.
  const WalkTargets& Advance(const PlanDrift& drift);
  const WalkTargets& targets() const { return targets_; }

  /// Ends the steps as soon as the footprints that preview control has seen allow, feet side by side. The path's end
  /// is as good; a stretch of steps that is about to begin is put off.
  void Halt();
  /// It was halted, and has come to stand.
  bool Halted() const;
  /// Each begins a stretch of steps (FootstepPlanner has the same names), whose first one begins when the preview has
  /// seen it. @pre Halted().
  void GoOn(const PlanDrift& drift);
  void TurnOnTheSpot(double turn_rad, const PlanDrift& drift);  ///< And halts again.
  void FollowPath(const PlanDrift& drift);
  void Walk(const Velocity& velocity, const PlanDrift& drift);
  void GoTo(const PlanarPose& goal, const PlanDrift& drift);  ///< The goal in W.
  /// Another velocity for the steps to come. @pre walking at one, not halted.
  void ChangeVelocity(const Velocity& velocity) { planner_.Walk(velocity); }

  /// The next Advance() begins a step, and may append footprints.
  bool StepIsDue() const { return StepAt(time() + options_.control_period_s) != StepAt(time()); }
  /// The time of the present targets, s.
  double time() const { return double(tick_) * options_.control_period_s; }
  /// Stood for the settling time after the last step.
  bool Finished() const;
  const FootstepPlanner& planner() const { return planner_; }
  /// Of the present stretch of steps.
  int first_step() const { return first_step_; }
  const Eigen::Vector2d cart_zmp() const { return preview_.Zmp(); }

 private:
  int StepAt(double time) const;
  /// The number of the step that will not be made, of all stretches together.
  int StepCount() const { return planner_.ended() ? planner_.count() - 2 : 1 << 30; }
  double PhaseAt(double time, int step) const;
  void Resume(const PlanDrift& drift);
  void BeginStretch(const PlanDrift& drift);
  void FillReference();
  Eigen::Vector2d SupportZmp(int print) const;
  Eigen::Vector2d RestZmp(int print) const;
  Eigen::Vector2d ZmpAt(double time) const;
  void AppendPrints(int step, const PlanDrift& drift);
  void PlaceFeet(int step, double phase);
  void PlaceSwingFoot(int step, double swing_phase);

  GaitOptions gait_;
  WalkPatternOptions options_;
  FootstepPlanner planner_;
  PreviewControl preview_;
  WalkTargets targets_;
  FootstepPlanner rested_;  ///< As it was before the present stretch.
  double begin_s_;          ///< Of that stretch; infinite while it is put off.
  int first_step_ = 0;      ///< Of that stretch.
  bool halted_ = false;
  int64_t tick_ = -1;
  std::vector<Eigen::Vector2d> reference_;
};

}  // namespace gaitcam
