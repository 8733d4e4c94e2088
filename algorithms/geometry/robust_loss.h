/// Losses that limit the pull of outliers.

#pragma once

#include <cmath>

namespace gaitcam {

/// Half a robust loss of a squared residual, and the weight that it gives the residual: twice its slope (B. Triggs,
/// P. McLauchlan, R. Hartley and A. Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000, section 4.3, without the
/// term of second order).
struct Loss {
  double cost = 0, weight = 1;
};

inline Loss HuberLoss(double squared, double threshold) {
  if (squared <= threshold * threshold) return {0.5 * squared, 1};
  const double size = std::sqrt(squared);
  return {threshold * size - 0.5 * threshold * threshold, threshold / size};
}

}  // namespace gaitcam
