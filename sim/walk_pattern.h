/// The plan of a walk in time: from footprints to what feet, root and centre of mass should do at each control tick.
///
/// Step k stands on print k + 1 while the other foot swings from print k to print k + 2. It begins with both feet down,
/// while the planned ZMP moves from the old support to the new one. Before the first and after the last step the robot
/// stands on both feet.

#pragma once

#include <array>
#include <vector>

#include "sim/controller.h"
#include "sim/footsteps.h"
#include "sim/posture.h"
#include "sim/preview_control.h"

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
  Eigen::Vector2d dcm;       ///< Divergent component of motion that goes with it, m.
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

  /// The next Advance() begins a step, and may append footprints.
  bool StepIsDue() const { return StepAt(time() + options_.control_period_s) != StepAt(time()); }
  /// The time of the present targets, s.
  double time() const { return double(tick_) * options_.control_period_s; }
  /// Stood for the settling time after the last step.
  bool Finished() const;
  const FootstepPlanner& planner() const { return planner_; }
  const Eigen::Vector2d cart_zmp() const { return preview_.Zmp(); }

 private:
  int StepAt(double time) const;
  int StepCount() const { return planner_.complete() ? planner_.count() - 2 : 1 << 30; }
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
  int64_t tick_ = -1;
  std::vector<Eigen::Vector2d> reference_;
};

}  // namespace gaitcam
