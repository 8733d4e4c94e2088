#include "algorithms/odometry/step_reckoning.h"

#include <cmath>

namespace gaitcam {

void StepReckoning::Add(const std::vector<JointSample>& samples, double heading_rad) {
  for (const JointSample& sample : samples) {
    if (sample.left_contact == sample.right_contact) continue;
    const Leg leg = sample.left_contact ? Leg::kLeft : Leg::kRight;
    if (last_ != Leg::kNone && leg != last_) {
      ++steps_;
      position_ += Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    }
    last_ = leg;
  }
}

}  // namespace gaitcam
