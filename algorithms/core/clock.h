/// The clock of all simulated sensors.

#pragma once

#include <cstdint>

namespace gaitcam {

/// What it shows when a simulated walk begins. Like the clocks of recorded datasets it counts from an epoch and has ten
/// digits of seconds: names made of stamps have one length and sort by time. A double of seconds so large is exact to
/// 0.24 us only: stamps are subtracted as int64_t, and only the difference is converted.
inline constexpr int64_t kClockStart_ns = 1'700'000'000'000'000'000;

/// Since the walk began, s.
inline double SecondsIntoWalk(int64_t stamp_ns) { return double(stamp_ns - kClockStart_ns) * 1e-9; }

}  // namespace gaitcam
