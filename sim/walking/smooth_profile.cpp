#include "sim/walking/smooth_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gaitcam {

using std::numbers::pi;

// Speed v (1 - cos(pi t / T)) / 2 during a ramp of T = pi v / (2 a): its steepest slope is a, its way v T / 2.
SmoothProfile::SmoothProfile(double distance, double speed, double acceleration) : distance_(distance) {
  speed_ = std::min(speed, std::sqrt(2 * acceleration * distance / pi));  // too short a way for the full speed
  if (!(speed_ > 0)) return;
  ramp_s_ = pi * speed_ / (2 * acceleration);
  cruise_s_ = std::max(0.0, distance / speed_ - ramp_s_);
}

double SmoothProfile::RampPosition(double t) const {
  return 0.5 * speed_ * (t - ramp_s_ / pi * std::sin(pi * t / ramp_s_));
}

double SmoothProfile::Position(double t) const {
  if (t <= 0) return 0;
  if (t >= duration_s()) return distance_;
  if (t < ramp_s_) return RampPosition(t);
  if (t < ramp_s_ + cruise_s_) return 0.5 * speed_ * ramp_s_ + speed_ * (t - ramp_s_);
  return distance_ - RampPosition(duration_s() - t);
}

double SmoothProfile::Speed(double t) const {
  const double into = std::min(t, duration_s() - t);
  if (into <= 0) return 0;
  return into >= ramp_s_ ? speed_ : 0.5 * speed_ * (1 - std::cos(pi * into / ramp_s_));
}

}  // namespace gaitcam
