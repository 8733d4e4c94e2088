/// The pose X_WP of the plan's frame P in the world, which drifts as feet slip.

#pragma once

#include "sim/walking/footsteps.h"

namespace gaitcam {

/// Averages the difference between measured and planned course over a step, so that sway and lag within it cancel.
class Course {
 public:
  /// One instant: the root as measured in W, and as planned in P.
  void Add(const PlanarPose& X_WB, const PlanarPose& X_PB);
  bool empty() const { return count_ == 0; }
  /// @returns X_WP and how it turns, its heading continuing the last one's without wrapping; begins a new average. @pre
  /// not empty.
  PlanDrift Take();

 private:
  static constexpr double kSlipMemory = 0.1;  ///< Part of the slip that the last step decides.

  double slip_rad_ = 0;
  double heading_ = 0;   ///< The last answer's, rad.
  double turn_sum_ = 0;  ///< Of differences from it.
  Eigen::Vector2d measured_sum_ = Eigen::Vector2d::Zero(), planned_sum_ = Eigen::Vector2d::Zero();
  int count_ = 0;
};

}  // namespace gaitcam
