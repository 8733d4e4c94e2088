/// Where a walker has come to, by counting its steps along its heading.
///
/// Foot switches and a gyroscope's heading are all it takes; a step straight ahead is the unit of length, as nobody
/// says how long it is. The more a step turns the less far it leads, and one that turns by `on_the_spot_rad` leads
/// nowhere; the default is fitted to khr1hv_pan's normal gait. results/studies/corridor_loops shows what it is good
/// for.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "algorithms/core/observation.h"

namespace gaitcam {

class StepReckoning {
 public:
  /// @param on_the_spot_rad turn of a step that leads nowhere, > 0.
  explicit StepReckoning(double on_the_spot_rad = 0.15) : on_the_spot_rad_(on_the_spot_rad) {}

  /// A step is made where the robot stands on the other leg than the last time it stood on one.
  /// @param heading_rad while these samples were taken, left positive, not wrapped.
  void Add(const std::vector<JointSample>& samples, double heading_rad);

  /// From where it began, forward at heading 0 and left of it, steps.
  const Eigen::Vector2d& position() const { return position_; }
  void SetPosition(const Eigen::Vector2d& position) { position_ = position; }
  /// Made altogether, also those on the spot.
  int steps() const { return steps_; }

 private:
  enum class Leg { kNone, kLeft, kRight };

  /// A trunk sways to and fro with each pair of steps: turns are looked at over two of them.
  static constexpr size_t kSteps = 4;

  double on_the_spot_rad_;
  std::array<double, kSteps> headings_{};  ///< Of the last steps; that of step k at k % kSteps.
  Leg last_ = Leg::kNone;
  int steps_ = 0;
  Eigen::Vector2d position_{0, 0};
};

}  // namespace gaitcam
