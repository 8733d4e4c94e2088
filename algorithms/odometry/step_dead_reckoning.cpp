#include "algorithms/odometry/step_dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {

void StepDeadReckoning::Add(const std::vector<JointSample>& samples, double heading_rad) {
  for (const JointSample& sample : samples) {
    if (sample.left_contact == sample.right_contact) continue;
    const Leg leg = sample.left_contact ? Leg::kLeft : Leg::kRight;
    if (last_ != Leg::kNone && leg != last_) {
      double& before_rad = headings_[size_t(steps_) % kSteps];
      const double turn_rad = size_t(steps_) < kSteps ? 0 : std::abs(heading_rad - before_rad) / double(kSteps);
      before_rad = heading_rad;
      ++steps_;
      position_ += std::max(0.0, 1 - turn_rad / stationary_turn_rad_) *
                   Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    }
    last_ = leg;
  }
}

}  // namespace gaitcam
