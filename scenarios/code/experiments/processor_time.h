/// Time that this process has computed, which other programs on the machine do not lengthen.

#pragma once

#include <ctime>

namespace gaitcam {

/// Of all threads of this process, ms since it began.
inline double ProcessorTime_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

}  // namespace gaitcam
