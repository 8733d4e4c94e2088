/// Dead reckoning of a walker from foot switches and a heading: each step advances the position along the heading.
///
/// The unit of length is a step straight ahead, whose length is not known. A step that turns is shorter, in proportion
/// to its turn; one that turns by `stationary_turn_rad` has no length. The default is fitted to khr1hv_pan's normal
/// gait; results/studies/corridor_loops shows the accuracy.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "algorithms/core/observation.h"

namespace gaitcam {

class StepDeadReckoning {
 public:
  /// @param stationary_turn_rad turn of a step that has no length, > 0.
  explicit StepDeadReckoning(double stationary_turn_rad = 0.15) : stationary_turn_rad_(stationary_turn_rad) {}

  /// A step is counted where the supporting leg is another than the last one.
  /// @param heading_rad while these samples were taken, left positive, not wrapped.
  void Add(const std::vector<JointSample>& samples, double heading_rad);

  /// From the start, in steps: x forward at heading 0, y to the left.
  const Eigen::Vector2d& position() const { return position_; }
  void SetPosition(const Eigen::Vector2d& position) { position_ = position; }
  /// Counted altogether, also those without length.
  int steps() const { return steps_; }

 private:
  enum class Leg { kNone, kLeft, kRight };

  /// The trunk sways with each pair of steps: turns are averaged over two pairs.
  static constexpr size_t kSteps = 4;

  double stationary_turn_rad_;
  std::array<double, kSteps> headings_{};  ///< Of the last steps; that of step k at k % kSteps.
  Leg last_ = Leg::kNone;
  int steps_ = 0;
  Eigen::Vector2d position_{0, 0};
};

}  // namespace gaitcam
