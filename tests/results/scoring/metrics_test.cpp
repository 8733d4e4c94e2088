#include "results/scoring/metrics.h"

#include <gtest/gtest.h>

#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

constexpr double kDeg = 180 / std::numbers::pi;

/// Straight ahead along x, level, `step_m` per frame.
Trajectory Straight(int frames, double step_m) {
  Trajectory t;
  for (int i = 0; i < frames; ++i) t.push_back({i * kFrame_ns, Pose(LookAlong(0), {step_m * i, 0, 0.3})});
  return t;
}

/// Turning on the spot through the given headings, with a nodding head.
Trajectory Headings(const std::vector<double>& headings, double nod_rad) {
  Trajectory t;
  for (size_t i = 0; i < headings.size(); ++i) {
    const double nod = nod_rad * std::sin(0.7 * double(i));
    t.push_back({int64_t(i) * kFrame_ns, Pose(Eigen::Matrix3d(LookAlong(headings[i]) * RotX(nod)), {0, 0, 0.3})});
  }
  return t;
}

TEST(Statistics, OfOneToFour) {
  const Statistics s = Summarize({3, 1, 4, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.min, 1);
  EXPECT_DOUBLE_EQ(s.max, 4);
}

TEST(Statistics, OfNothingAreNotNumbers) { EXPECT_TRUE(std::isnan(Summarize({}).rmse)); }

TEST(AbsoluteError, OfAKnownOffsetIsItsLength) {
  const Trajectory truth = Straight(5, 0.1);
  Similarity shift;
  shift.translation = {0, 3, 4};
  for (const double e : PositionErrors(PairUp(truth, Moved(shift, truth)))) EXPECT_NEAR(e, 5, 1e-14);
}

TEST(AbsoluteError, OfAKnownTurnIsItsAngle) {
  const Trajectory truth = SwayingCircle(30, 1, 3);
  Trajectory turned = truth;
  for (StampedPose& p : turned) p.pose.rotation = p.pose.rotation * Eigen::Quaterniond(RotY(0.25));
  for (const double e : RotationErrors(PairUp(truth, turned))) EXPECT_NEAR(e, 0.25, 1e-14);
}

TEST(AbsoluteError, FullErrorOfAQuarterTurnAndAShift) {
  // |R - I| of a quarter turn is 2, so with a shift of 1.5 the whole is sqrt(4 + 2.25) = 2.5.
  Pose off(RotZ(std::numbers::pi / 2), {0, 0, 1.5});
  std::vector<PosePair> pairs = {{0, Pose(), off, {}}};
  EXPECT_NEAR(FullErrors(pairs).at(0), 2.5, 1e-14);
}

TEST(RelativeError, DoesNotSeeWhereTheWorldsLie) {
  RandomStream random(1, "metrics");
  const Trajectory truth = SwayingCircle(90, 1, 3);
  const auto pairs = PairUp(truth, Moved(RandomSimilarity(random, false), truth));
  for (const DeltaUnit unit : {DeltaUnit::kFrames, DeltaUnit::kSeconds, DeltaUnit::kMeters}) {
    const auto errors = RelativeErrors(pairs, {.delta = 1, .unit = unit});
    EXPECT_GT(errors.size(), 20u);
    for (const RelativeError& e : errors) {
      EXPECT_LT(e.translation_m, 1e-12);
      EXPECT_LT(e.rotation_rad, 1e-12);
    }
  }
}

TEST(RelativeError, OverFramesOfATooLongStepIsTheExcess) {
  const auto pairs = PairUp(Straight(11, 0.1), Straight(11, 0.13));
  const auto all = RelativeErrors(pairs, {.delta = 2, .unit = DeltaUnit::kFrames});
  ASSERT_EQ(all.size(), 9u);
  for (const RelativeError& e : all) EXPECT_NEAR(e.translation_m, 0.06, 1e-14);
  const auto consecutive = RelativeErrors(pairs, {.delta = 2, .unit = DeltaUnit::kFrames, .all_pairs = false});
  ASSERT_EQ(consecutive.size(), 5u);
  for (size_t k = 0; k < 5; ++k) EXPECT_EQ(consecutive[k].from, 2 * k);
}

TEST(RelativeError, OverASecondOfATooFastWalkIsTheExcessSpeed) {
  const auto errors =
      RelativeErrors(PairUp(Straight(61, 0.010), Straight(61, 0.013)), {.delta = 1, .unit = DeltaUnit::kSeconds});
  // 30 frames of 33.333333 ms are the nearest to a second; the last two intervals, of 29 and 28, are within a tenth of
  // it.
  ASSERT_EQ(errors.size(), 33u);
  for (const RelativeError& e : errors) {
    EXPECT_EQ(e.to, std::min<size_t>(e.from + 30, 60));
    EXPECT_NEAR(e.translation_m, double(e.to - e.from) * 0.003, 1e-13);
  }
}

TEST(RelativeError, OverSecondsSkipsIntervalsThatAGapMakesTooLong) {
  auto pairs = PairUp(Straight(61, 0.01), Straight(61, 0.01));
  pairs.erase(pairs.begin() + 20, pairs.begin() + 40);
  for (const RelativeError& e : RelativeErrors(pairs, {.delta = 0.2, .unit = DeltaUnit::kSeconds})) {
    EXPECT_NEAR(double(pairs[e.to].stamp_ns - pairs[e.from].stamp_ns) * 1e-9, 0.2, 0.02);
  }
}

TEST(RelativeError, OverMetresFollowsTheTruePathWhateverTheEstimatesScale) {
  const auto pairs = PairUp(Straight(101, 0.0625), Straight(101, 0.625));  // binary fractions: 16 steps are a metre
  const auto errors = RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kMeters});
  ASSERT_EQ(errors.size(), 86u);  // the last one of 15 steps, which is within a tenth of a metre
  for (const RelativeError& e : errors) {
    EXPECT_EQ(e.to, std::min<size_t>(e.from + 16, 100));
    EXPECT_NEAR(e.translation_m, double(e.to - e.from) * 0.5625, 1e-12);
  }
  const auto by_estimate =
      RelativeErrors(pairs, {.delta = 1.25, .unit = DeltaUnit::kMeters, .path = RpePath::kEstimate});
  ASSERT_FALSE(by_estimate.empty());
  for (const RelativeError& e : by_estimate) EXPECT_EQ(e.to - e.from, 2u);
}

TEST(RelativeError, OfARunThatIsTooShortIsEmpty) {
  const auto pairs = PairUp(Straight(5, 0.01), Straight(5, 0.01));
  for (const bool all : {true, false}) {
    EXPECT_TRUE(RelativeErrors(pairs, {.delta = 5, .unit = DeltaUnit::kFrames, .all_pairs = all}).empty());
    EXPECT_TRUE(RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kSeconds, .all_pairs = all}).empty());
    EXPECT_TRUE(RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kMeters, .all_pairs = all}).empty());
    EXPECT_TRUE(RelativeErrors({}, {.delta = 1, .unit = DeltaUnit::kMeters, .all_pairs = all}).empty());
  }
}

TEST(Drift, OfAnEstimateTenPercentTooLongIsTenPercent) {
  const Drift drift = MeasureDrift(PairUp(Straight(201, 0.01), Straight(201, 0.011)));
  EXPECT_NEAR(drift.translation_pct, 10, 1e-9);
  EXPECT_NEAR(drift.end_pct, 10, 1e-9);
  EXPECT_NEAR(drift.rotation_deg_per_m, 0, 1e-6);
}

TEST(Drift, OfASteadyTurnIsItsRatePerMetre) {
  const Trajectory truth = Straight(401, 0.005);
  Trajectory turning = truth;
  for (StampedPose& p : turning) p.pose.rotation = RotZ(0.1 * p.pose.translation.x()) * p.pose.rotation;
  EXPECT_NEAR(MeasureDrift(PairUp(truth, turning)).rotation_deg_per_m, 0.1 * kDeg, 1e-9);
}

TEST(Drift, OfATruthThatStandsIsNotANumber) {
  const Trajectory still = Straight(20, 0);
  EXPECT_TRUE(std::isnan(MeasureDrift(PairUp(still, Straight(20, 0.1))).translation_pct));
  EXPECT_TRUE(std::isnan(MeasureDrift({}).end_pct));
}

TEST(ScaleDrift, OfAnExponentiallyGrowingScaleIsItsRate) {
  // Scale exp(k s) at path s: displacements over equal lengths grow by exactly exp(k) per metre.
  const double k = 0.05;
  const Trajectory truth = Straight(401, 0.01);
  Trajectory growing = truth;
  for (StampedPose& p : growing) p.pose.translation.x() = 0.4 * std::expm1(k * p.pose.translation.x()) / k;
  // 1e-9: a step more or less in a sub-path, as rounding has it, leaves the logarithm of the ratio as it is up to (k
  // step)^2.
  EXPECT_NEAR(ScaleDriftPctPerM(PairUp(truth, growing)), 100 * std::expm1(k), 2e-2);
  EXPECT_NEAR(ScaleDriftPctPerM(PairUp(truth, truth)), 0, 1e-9);
}

TEST(ScaleDrift, IsNotMovedByOneJump) {
  const Trajectory truth = Straight(401, 0.01);
  Trajectory jumped = truth;
  for (size_t i = 200; i < jumped.size(); ++i) jumped[i].pose.translation.x() += 1;
  EXPECT_LT(std::abs(ScaleDriftPctPerM(PairUp(truth, jumped))), 1);
}

std::vector<double> Ramp(double from, double to, int frames) {
  std::vector<double> headings;
  for (int i = 0; i < frames; ++i) headings.push_back(from + (to - from) * i / frames);
  return headings;
}

std::vector<double> Scaled(std::vector<double> values, double factor) {
  for (double& v : values) v *= factor;
  return values;
}

TEST(RotationGain, OfAnOverTurningEstimateIsItsFactor) {
  const auto headings = Ramp(0, 7, 300);
  const Turn turn = MeasureTurn(PairUp(Headings(headings, 0), Headings(Scaled(headings, 1.2), 0)));
  EXPECT_NEAR(turn.Gain(), 1.2, 1e-9);
  EXPECT_NEAR(turn.true_rad, 7.0 * 299 / 300, 1e-9);
}

TEST(RotationGain, DoesNotNeedTheWorldsToAgree) {
  RandomStream random(2, "metrics");
  const auto headings = Ramp(0, -4, 300);
  const Trajectory estimate = Moved(RandomSimilarity(random, true), Headings(Scaled(headings, 0.9), 0.1));
  // A nodding head couples a little of the turn into other axes: second order in the nod, 0.1 rad.
  EXPECT_NEAR(MeasureTurn(PairUp(Headings(headings, 0.1), estimate)).Gain(), 0.9, 0.01);
}

TEST(RotationGain, LeftAndRightAddUp) {
  std::vector<double> headings = Ramp(0, 2, 100);
  for (const double h : Ramp(2, 0, 100)) headings.push_back(h);
  const Turn turn = MeasureTurn(PairUp(Headings(headings, 0), Headings(Scaled(headings, 1.5), 0)));
  EXPECT_NEAR(turn.true_rad, 4, 0.05);  // the last frame ends a step of 0.02 before zero
  EXPECT_NEAR(turn.Gain(), 1.5, 1e-9);
}

TEST(RotationGain, TheSwayOfAGaitIsNoTurn) {
  std::vector<double> sway;
  for (int i = 0; i < 600; ++i) sway.push_back(0.12 * std::sin(0.6 * i));
  EXPECT_TRUE(std::isnan(MeasureTurn(PairUp(Headings(sway, 0), Headings(sway, 0))).Gain()));
  // On top of a real turn it must not count either: 600 frames of sway alone would add up to 27 rad.
  std::vector<double> both = Ramp(0, 3, 600);
  for (size_t i = 0; i < both.size(); ++i) both[i] += sway[i];
  EXPECT_NEAR(MeasureTurn(PairUp(Headings(both, 0), Headings(both, 0))).true_rad, 3,
              0.13);  // the sway of the last frame
}

TEST(RotationGain, AWrongTurnCountsAtWhateverFrame) {
  const auto headings = Ramp(0, 4, 401);
  auto estimate = Headings(headings, 0);
  for (size_t i = 200; i < estimate.size(); ++i) estimate[i].pose.rotation = RotZ(2) * estimate[i].pose.rotation;
  EXPECT_NEAR(MeasureTurn(PairUp(Headings(headings, 0), estimate)).Gain(), 1.5, 0.01);  // a frame turns by 0.01
}

TEST(PeakMemory, IsOfThisProcess) {
  const double before = PeakMemoryMb();
  EXPECT_GT(before, 1);
  const std::vector<char> block(size_t(before + 64) << 20, 1);  // more than there ever was, whatever ran before
  EXPECT_GE(PeakMemoryMb(), before + 32 * block[1000]);
}

}  // namespace
}  // namespace gaitcam
