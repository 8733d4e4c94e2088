/// The middle one of some values, where a value that really occurs is wanted; results/statistics.h has the median that
/// statistics mean.

#pragma once

#include <algorithm>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {

/// The middle value; of an even number the greater one of the two in the middle. @pre There is one.
template <class Value>
Value UpperMedian(std::vector<Value> values) {
  GAITCAM_ASSERT(!values.empty());
  const auto middle = values.begin() + long(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace gaitcam
