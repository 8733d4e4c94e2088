#include "scenarios/code/experiments/threshold_search.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

Threshold FindThreshold(double largest, int halvings, const std::function<bool(double)>& fails) {
  GAITCAM_ASSERT(largest > 0 && halvings >= 0);
  Threshold found;
  double high = largest;
  if (!fails(largest)) {
    found.holds_at = largest;
    if (halvings == 0 || !fails(largest / 2)) return found;
    found = {0, std::nullopt, false};
    high = largest / 2;
    --halvings;
  }
  for (int i = 0; i < halvings; ++i) {
    const double middle = (found.holds_at + high) / 2;
    (fails(middle) ? high : found.holds_at) = middle;
  }
  found.fails_at = high;
  if (found.is_monotone && high < largest) found.is_monotone = fails((high + largest) / 2);
  return found;
}

}  // namespace gaitcam
