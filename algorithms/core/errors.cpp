#include "algorithms/core/errors.h"

namespace gaitcam::internal {

void AssertionFailed(const char* condition, const char* file, int line) {
  throw std::logic_error(std::string("internal error: ") + condition + " does not hold at " + file + ":" +
                         std::to_string(line));
}

}  // namespace gaitcam::internal
