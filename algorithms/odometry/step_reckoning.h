/// Where a walker has come to, by counting its steps along its heading.
///
/// Foot switches and a gyroscope's heading are all it takes; a step is the unit of length, as nobody says how long it
/// is. It drifts with every step that is longer or shorter than the others, as those of a turn are.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/observation.h"

namespace gaitcam {

class StepReckoning {
 public:
  /// A step is made where the robot stands on the other leg than the last time it stood on one.
  /// @param heading_rad while these samples were taken, left positive.
  void Add(const std::vector<JointSample>& samples, double heading_rad);

  /// From where it began, forward at heading 0 and left of it, steps.
  const Eigen::Vector2d& position() const { return position_; }
  void SetPosition(const Eigen::Vector2d& position) { position_ = position; }
  /// Made altogether.
  int steps() const { return steps_; }

 private:
  enum class Leg { kNone, kLeft, kRight };

  Leg last_ = Leg::kNone;
  int steps_ = 0;
  Eigen::Vector2d position_{0, 0};
};

}  // namespace gaitcam
