#include "models/code/people/crowd_forces.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {
namespace {

using Eigen::Vector2d;

// Moussaid et al. (2009), section 3c.
constexpr double kRelaxation_s = 0.54;
constexpr double kStrength = 4.5;                // A, m/s^2
constexpr double kRange = 0.35;                  // gamma
constexpr double kTurning = 2, kSlowing = 3;     // n and n'
constexpr double kWeightOfVelocity = 2;          // lambda
constexpr double kWall = 3, kWallRange_m = 0.1;  // a, m/s^2, and b
constexpr double kSidePreference = 0.005;        // epsilon of Moussaid et al., PLoS ONE 5 (2010)
// Helbing et al. (2000): A = 2000 N, m = 80 kg, B, and the sum of two radii.
constexpr double kTouch = 2000.0 / 80, kTouchRange_m = 0.08, kTouching_m = 0.5;
constexpr double kLeast_m = 0.05, kLeast = 1e-6;  // where the equations have no value

}  // namespace

Vector2d DrivingForce(const Vector2d& wanted, const Vector2d& velocity) { return (wanted - velocity) / kRelaxation_s; }

Vector2d AvoidingForce(const Passer& self, const Passer& other, double nearer_m) {
  const Vector2d between = other.position - self.position;
  if (between.norm() < kLeast) return {0, 0};
  const double distance = std::max(kLeast_m, between.norm() - nearer_m);
  const Vector2d e = between.normalized();
  const Vector2d D = kWeightOfVelocity * (self.velocity - other.velocity) + e;
  if (D.norm() < kLeast) return {0, 0};
  const Vector2d t = D.normalized(), left(-t.y(), t.x());
  const double B = kRange * D.norm();
  // From the interaction's direction t to the other one, with a slight preference of a side.
  const double theta = std::atan2(t.x() * e.y() - t.y() * e.x(), t.dot(e)) + B * kSidePreference;
  const auto decay = [&](double n) { return std::exp(-distance / B - (n * B * theta) * (n * B * theta)); };
  const double side = theta > 0 ? 1 : -1;
  return -kStrength * (decay(kSlowing) * t + side * decay(kTurning) * left);
}

Vector2d TouchForce(double distance_m, const Vector2d& away) {
  return kTouch * std::exp((kTouching_m - distance_m) / kTouchRange_m) * away;
}

Vector2d WallForce(double gap_m, const Vector2d& away) {
  return kWall * std::exp(-std::max(0.0, gap_m) / kWallRange_m) * away;
}

}  // namespace gaitcam
