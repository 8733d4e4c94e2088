/// The body's own odometry: how often it is read, and what is wrong with wheels. Legs err by their own encoders,
/// gyroscope and slip.

#pragma once

#include "algorithms/core/fields.h"
#include "algorithms/core/units.h"

namespace gaitcam {

struct OdometryOptions {
  using DescribedTag = void;
  double rate_hz = 50;
  double wheel_radius_pct = 1;
  double wheel_difference_pct = 0.1;
  double wheel_distance_pct = 2;
  double slip_per_sqrt_m = 0.003;
  int ticks_per_turn = 2048;
};

template <class Visitor>
void VisitFields(Visitor& visit, OdometryOptions& o) {
  visit("rate_hz", o.rate_hz, Between(1, 1000), "samples per second, at most one per physics step");
  visit("wheel_radius_pct", o.wheel_radius_pct, Between(0, 20),
        "1 sigma; radius of all wheels alike: the way's scale; systematic errors as Borenstein and Feng (1996)");
  visit("wheel_difference_pct", o.wheel_difference_pct, Between(0, 20), "1 sigma; radius of each wheel alone: bends");
  visit("wheel_distance_pct", o.wheel_distance_pct, Between(0, 20),
        "1 sigma; distance of the wheels from the middle: the turn's scale");
  visit("slip_per_sqrt_m", o.slip_per_sqrt_m, Between(0, 1),
        "1 sigma of a wheel's slip after it rolled 1 m, m; the variance grows with the way (Siegwart and Nourbakhsh, "
        "eq. 5.8)");
  visit("ticks_per_turn", o.ticks_per_turn, Between(0, 1e6), "of a wheel's encoder; 0 is continuous");
}

/// Way and turn for which a data sheet's random walk is as wide as systematic errors.
constexpr double kDataSheetWay_m = 10;
constexpr double kDataSheetTurn_rad = 2 * kPi;

}  // namespace gaitcam
