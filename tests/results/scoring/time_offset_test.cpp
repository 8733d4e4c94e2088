#include "results/scoring/time_offset.h"

#include <gtest/gtest.h>

#include "algorithms/core/units.h"
#include "results/scoring/score.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

/// A walker's heading over t: turning left, and swaying as a gait does.
Pose At(double t) {
  const double sway = 2 * std::numbers::pi * t / 0.7;
  const Eigen::Matrix3d R = LookAlong(0.1 * t + 0.03 * std::sin(sway)) * RotX(0.02 * std::sin(2 * sway));
  return Pose(R, {0.15 * t, 0.01 * std::sin(sway), 0.3});
}

Trajectory Film(double rate_hz, double late_s) {
  Trajectory film;
  for (int i = 0; i < int(8 * rate_hz); ++i) {
    film.push_back({int64_t(std::llround(1e9 * i / rate_hz)), At(i / rate_hz - late_s)});
  }
  return film;
}

double OffsetOf(double rate_hz, double late_s, double noise_rad) {
  RandomStream random(2, "offset");
  const Trajectory truth = Film(rate_hz, 0);
  const Trajectory estimate = Noisy(Film(rate_hz, late_s), random, 0, noise_rad);
  return EstimateTimeOffsetMs(AssociatePoses(EstimateFromTrajectory(estimate).frames, truth, {}), truth);
}

// The poses of 20 ms ago: what a program says that stamps its poses late.
TEST(TimeOffset, IsFoundToAMillisecond) {
  for (const double rate_hz : {10.0, 30.0}) {
    for (const double late_s : {0.0, 0.005, 0.02, -0.05}) {
      // Between frames at 10 Hz the cubic misses the sway at 2.9 Hz by a tenth of it: 2 ms.
      EXPECT_NEAR(OffsetOf(rate_hz, late_s, 0), 1e3 * late_s, rate_hz < 20 ? 2.0 : 0.5) << rate_hz << " " << late_s;
    }
  }
}

TEST(TimeOffset, IsFoundUnderATrackersNoise) {
  EXPECT_NEAR(OffsetOf(30, 0.02, 0.0005), 20, 1.5);
  EXPECT_NEAR(OffsetOf(10, 0.02, 0.0005), 20, 3);
}

TEST(TimeOffset, OfWhoDoesNotTurnIsNotKnown) {
  Trajectory truth;
  for (int i = 0; i < 100; ++i) truth.push_back({i * kFrame_ns, Pose(LookAlong(0), {0.01 * i, 0, 0})});
  RandomStream random(2, "offset");
  const Trajectory estimate = Noisy(truth, random, 0.001, 0.001);
  EXPECT_TRUE(std::isnan(EstimateTimeOffsetMs(PairUp(truth, estimate), truth)));
  EXPECT_TRUE(std::isnan(EstimateTimeOffsetMs({}, truth)));
}

}  // namespace
}  // namespace gaitcam
