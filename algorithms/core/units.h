/// Constants that every room needs.

#pragma once

#include <limits>
#include <numbers>

namespace gaitcam {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kRadPerDeg = kPi / 180;
inline constexpr double kDegPerRad = 180 / kPi;
inline constexpr double kNsPerMs = 1e6;
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace gaitcam
