/// Levenberg and Marquardt's method for sparse problems that know how to solve their own equations.

#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

namespace gaitcam {

struct LevenbergMarquardtResult {
  double cost_before = 0, cost_after = 0;
};

/// Refines `state` in place. The damping follows how well the linearised problem foretells the cost (H. B. Nielsen,
/// "Damping parameter in Marquardt's method", 1999).
/// @param equations has: double Linearize(const State&), the cost there; double CostAt(const State&);
///        std::optional<Step> Solve(double damping), where Step::gain is the foretold decrease; and
///        State Moved(const State&, const Step&). It is linearised at the final state, unless the last iteration moved.
template <class Equations, class State>
LevenbergMarquardtResult MinimizeLevenbergMarquardt(Equations& equations, int max_iterations, State& state) {
  constexpr double kFirstDamping = 1e-4, kLeastDamping = 1e-16, kLeastQuality = 1e-3, kConverged = 1e-6;
  double damping = kFirstDamping, growth = 2, cost = equations.Linearize(state);
  const double cost_before = cost;
  for (int i = 0; i < max_iterations; ++i) {
    const auto step = equations.Solve(damping);
    State moved;
    double moved_cost = cost;
    if (step) {
      moved = equations.Moved(state, *step);
      moved_cost = equations.CostAt(moved);
      if (std::abs(cost - moved_cost) <= kConverged * cost) break;
    }
    const double quality = step ? (cost - moved_cost) / step->gain : 0;
    if (!(quality > kLeastQuality)) {
      damping *= growth;
      growth *= 2;
      continue;
    }
    damping = std::max(kLeastDamping, damping * std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3)));
    growth = 2;
    state = std::move(moved);
    cost = i + 1 < max_iterations ? equations.Linearize(state) : moved_cost;
  }
  return {cost_before, cost};
}

}  // namespace gaitcam
