#include "sim/walking/course.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

void Course::Add(const PlanarPose& X_WB, const PlanarPose& X_PB) {
  turn_sum_ += WrapAngle(X_WB.heading - X_PB.heading - heading_);
  measured_sum_ += X_WB.position;
  planned_sum_ += X_PB.position;
  ++count_;
}

PlanDrift Course::Take() {
  GAITCAM_ASSERT(count_ > 0);
  const double turned_rad = turn_sum_ / count_;
  slip_rad_ += kSlipMemory * (turned_rad - slip_rad_);
  heading_ += turned_rad;
  const PlanarPose turned({0, 0}, heading_);
  const PlanarPose X_WP((measured_sum_ - turned * planned_sum_) / count_, heading_);
  turn_sum_ = 0;
  measured_sum_.setZero();
  planned_sum_.setZero();
  count_ = 0;
  return {X_WP, slip_rad_};
}

}  // namespace gaitcam
