/// The level from which on something fails, by bisection, and whether bisection may be believed.

#pragma once

#include <functional>
#include <optional>

namespace gaitcam {

struct Threshold {
  double holds_at = 0;             ///< The largest level found to hold below `fails_at`; 0 is not tried, it holds.
  std::optional<double> fails_at;  ///< The smallest level found to fail; nothing: the largest level holds.
  /// What was tried above `fails_at` fails as well; where the largest level holds, half of it does, too. If not, a
  /// threshold does not describe what happens.
  bool is_monotone = true;
};

/// Tries the largest level, then halves the interval between what holds and what fails, and at last tries the middle
/// between the threshold found and the largest level. Where the largest level holds, half of it is tried.
/// @param halvings the threshold is found to largest / 2^halvings. At most halvings + 2 levels are tried.
/// @pre largest > 0, halvings >= 0.
Threshold FindThreshold(double largest, int halvings, const std::function<bool(double)>& fails);

}  // namespace gaitcam
