#include "sim/camera/shutter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace gaitcam {
namespace {

constexpr int64_t kMidExposure = 1000000000;

/// `speed(t)` in px over the whole shutter, t in [0, 1].
template <class Speed>
MotionProfile Profile(const ExposureOptions& options, Speed speed) {
  const ShutterInterval shutter = WholeShutter(options, kMidExposure);
  MotionProfile motion;
  constexpr int kParts = 64;
  double travel = 0;
  for (int i = 0; i <= kParts; ++i) {
    if (i > 0) travel += speed((i - 0.5) / kParts) / kParts;
    motion.stamps_ns.push_back(shutter.open_ns + (shutter.close_ns - shutter.open_ns) * i / kParts);
    motion.travel_px.push_back(travel);
  }
  motion.typical_px = travel;
  return motion;
}

TEST(Shutter, SlotsFillTheShutterAndWeightsAddUp) {
  const ExposureOptions options;
  const MotionProfile motion = Profile(options, [](double t) { return 10 + 30 * t; });
  const ShutterPlan plan = PlanShutter(options, kMidExposure, 4, motion);
  const ShutterInterval shutter = WholeShutter(options, kMidExposure);
  EXPECT_EQ(plan.front().open_ns, shutter.open_ns);
  EXPECT_EQ(plan.back().close_ns, shutter.close_ns);
  EXPECT_EQ(shutter.open_ns + shutter.close_ns, 2 * kMidExposure);
  EXPECT_EQ(shutter.close_ns - shutter.open_ns, 20000000);
  double weight = 0;
  Eigen::Vector2d shift(0, 0);
  for (size_t i = 0; i < plan.size(); ++i) {
    if (i > 0) {
      EXPECT_EQ(plan[i].open_ns, plan[i - 1].close_ns);
    }
    weight += plan[i].weight;
    shift += plan[i].weight * plan[i].shift_px;
  }
  EXPECT_NEAR(weight, 1, 1e-12);
  EXPECT_NEAR(shift.norm(), 0, 1e-12);  // anti-aliasing must not move the image
}

TEST(Shutter, NoPointMovesFurtherThanTheStepBetweenTwoSubframes) {
  ExposureOptions options;
  options.max_step_px = 0.5;
  const auto steady = [](double) { return 12.0; };
  const auto uneven = [](double t) { return t < 0.3 ? 2.0 : 40.0; };
  const auto stopping = [](double t) { return t > 0.5 ? 0.0 : 30.0; };
  for (const MotionProfile& motion : {Profile(options, steady), Profile(options, uneven), Profile(options, stopping)}) {
    const ShutterPlan plan = PlanShutter(options, kMidExposure, 1, motion);
    for (size_t i = 1; i < plan.size(); ++i) {
      EXPECT_LE(motion.TravelAt(plan[i].stamp_ns) - motion.TravelAt(plan[i - 1].stamp_ns), 0.5 + 1e-6);
    }
    // And hardly more sub-frames than the way needs.
    EXPECT_LE(double(plan.size()), 1.15 * motion.travel_px.back() / 0.5 + 2);
  }
}

TEST(Shutter, CountsStayWithinTheirBounds) {
  ExposureOptions options;
  options.min_subframes = 3;
  options.max_subframes = 20;
  const auto count = [&](double px, int antialias) {
    return PlanShutter(options, kMidExposure, antialias, Profile(options, [=](double) { return px; })).size();
  };
  EXPECT_EQ(count(0, 1), 3u);
  EXPECT_EQ(count(0, 8), 8u);
  EXPECT_EQ(count(500, 1), 20u);
  options.fixed_subframes = 5;
  EXPECT_EQ(count(500, 8), 5u);
  EXPECT_EQ(PlanShutter(options, kMidExposure, 8, {}).size(), 5u);
}

TEST(Shutter, AnInstantIsFilmedAtItsStamp) {
  ExposureOptions options;
  options.exposure_ms = 0;
  const ShutterPlan plan = PlanShutter(options, kMidExposure, 4, {});
  ASSERT_EQ(plan.size(), 4u);
  for (const ShutterSlot& slot : plan) EXPECT_EQ(slot.stamp_ns, kMidExposure);
}

TEST(Shutter, ARollingShuttersRowsOpenOneAfterTheOther) {
  ExposureOptions options;
  options.exposure_ms = 5;
  options.readout_ms = 30;
  EXPECT_EQ(RowShutter(options, kMidExposure, 0, 101).open_ns, kMidExposure - 17500000);
  EXPECT_EQ(RowShutter(options, kMidExposure, 50, 101).open_ns, kMidExposure - 2500000);
  EXPECT_EQ(RowShutter(options, kMidExposure, 100, 101).close_ns, kMidExposure + 17500000);
  EXPECT_EQ(WholeShutter(options, kMidExposure).open_ns, kMidExposure - 17500000);
  EXPECT_EQ(MiddleRowShutter(options, kMidExposure).close_ns, kMidExposure + 2500000);
}

TEST(Shutter, ARowsWeightsMeanItsOwnMiddle) {
  ExposureOptions options;
  options.exposure_ms = 5;
  options.readout_ms = 30;
  const MotionProfile motion = Profile(options, [](double t) { return 20 + 15 * std::sin(6 * t); });
  const ShutterPlan plan = PlanShutter(options, kMidExposure, 1, motion);
  for (int row = 0; row <= 100; row += 10) {
    const std::vector<float> weights = RowWeights(options, kMidExposure, plan, row, 101);
    const ShutterInterval own = RowShutter(options, kMidExposure, row, 101);
    double sum = 0, mean_ns = 0;
    for (size_t i = 0; i < plan.size(); ++i) {
      sum += weights[i];
      mean_ns += weights[i] * double(plan[i].stamp_ns - kMidExposure);
      if (weights[i] > 0) {
        EXPECT_LT(plan[i].open_ns, own.close_ns);
        EXPECT_GT(plan[i].close_ns, own.open_ns);
      }
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    // The first and last slot of a row are seen only in part, yet stand for their own middle: off by less than a slot.
    EXPECT_NEAR(mean_ns, 0.5 * double(own.open_ns + own.close_ns) - kMidExposure, 0.3e6);
  }
}

TEST(PlanKeys, EverySubframeHasOneKeyAndTheMiddleIsOne) {
  ExposureOptions options;
  for (const double total_px : {3.0, 20.0, 60.0}) {
    const MotionProfile motion = Profile(options, [&](double t) { return 4 * total_px * t * t * t; });  // a jolt
    const ShutterPlan plan = PlanShutter(options, kMidExposure, 4, motion);
    double reach_before = std::numeric_limits<double>::max();
    for (int keys = 1; keys <= std::min(9, int(plan.size())); keys += 2) {
      const std::vector<KeySlot> slots = PlanKeys(plan, kMidExposure, keys);
      ASSERT_EQ(int(slots.size()), keys);
      int next = 0, middles = 0;
      for (const KeySlot& slot : slots) {
        EXPECT_EQ(slot.first, next);
        EXPECT_GE(slot.end, slot.first);
        next = slot.end;
        middles += slot.stamp_ns == kMidExposure;
      }
      EXPECT_EQ(next, int(plan.size()));
      EXPECT_EQ(middles, 1);
      const double reach = LongestReach(slots, plan, motion);
      EXPECT_LE(reach, reach_before + 1e-9);  // more keys never lie further away
      EXPECT_LE(reach, total_px);
      reach_before = reach;
    }
  }
}

}  // namespace
}  // namespace gaitcam
