/// Motion in one dimension from rest to rest.

#pragma once

namespace gaitcam {

/// From rest to rest over a distance (m or rad): raised-cosine ramp up, constant speed, ramp down.
class SmoothProfile {
 public:
  SmoothProfile() = default;
  SmoothProfile(double distance, double speed, double acceleration);
  double duration_s() const { return 2 * ramp_s_ + cruise_s_; }
  double Position(double t) const;  ///< From 0 to the distance; clamped outside [0, duration].
  double Speed(double t) const;

 private:
  double RampPosition(double t) const;
  double distance_ = 0, speed_ = 0, ramp_s_ = 0, cruise_s_ = 0;
};

}  // namespace gaitcam
