#include "sim/walking/walk_pattern.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

WalkPattern Make(const GaitOptions& gait = {}, double length_m = 0.6) {
  PathOptions path;
  path.length_m = length_m;
  return {gait, {}, FootstepPlanner(gait, {}, Path(path, {}))};
}

TEST(WalkPattern, FeetMoveWithoutJumps) {
  WalkPattern pattern = Make();
  WalkTargets last = pattern.Advance({});
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    for (const int side : {0, 1}) {
      const Eigen::Vector3d moved = now.posture.X_PA[side].translation - last.posture.X_PA[side].translation;
      // Quintic over 95 % of a swing of 0.28 s: at most 1.875 x 80 mm / 0.266 s forwards, 1.875 x 20 mm / 0.14 s up.
      EXPECT_LT(moved.norm() / 0.004, 0.64);
    }
    last = now;
  }
}

TEST(WalkPattern, TheStandingFootStaysPut) {
  WalkPattern pattern = Make();
  WalkTargets last = pattern.Advance({});
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    if (now.stance >= 0 && now.gait.step == last.gait.step) {
      const size_t side = size_t(now.stance);
      EXPECT_EQ(now.posture.X_PA[side].translation, last.posture.X_PA[side].translation);
    }
    last = now;
  }
}

TEST(WalkPattern, SwingsAsHighAsAskedAndLandsWhereAsked) {
  GaitOptions gait;
  gait.lift_m = 0.03;
  gait.landing_offset_m = -0.005;
  WalkPattern pattern = Make(gait);
  double highest = 0, lowest = 1;
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    if (now.stance < 0) continue;
    const double height = now.posture.X_PA[size_t(1 - now.stance)].translation.z() - 0.03;
    highest = std::max(highest, height);
    lowest = std::min(lowest, height);
  }
  EXPECT_NEAR(highest, 0.03, 1e-5);  // the tick nearest to mid-swing
  EXPECT_NEAR(lowest, -0.005, 1e-4);
}

TEST(WalkPattern, WeightGoesFromFootToFootAndAddsUp) {
  WalkPattern pattern = Make();
  double last_left = 0.5;
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    EXPECT_NEAR(now.load[0] + now.load[1], 1, 1e-12);
    // Double support lasts 70 ms, 17.5 ticks.
    EXPECT_NEAR(now.load[0], last_left, 1 / 17.0);
    last_left = now.load[0];
    if (now.gait.support == SupportPhase::kLeft) {
      EXPECT_EQ(now.load[0], 1);
    }
    if (now.gait.support == SupportPhase::kRight) {
      EXPECT_EQ(now.load[1], 1);
    }
  }
}

TEST(WalkPattern, DoubleSupportTakesItsPartOfTheStep) {
  GaitOptions gait;
  gait.double_support_ratio = 0.4;
  WalkPattern pattern = Make(gait, 2.0);
  int both = 0, all = 0;
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    if (now.gait.step < 0) continue;
    ++all;
    both += now.gait.support == SupportPhase::kDouble;
  }
  EXPECT_NEAR(double(both) / all, 0.4, 0.01);  // rounding to ticks: one in 87
}

TEST(WalkPattern, TheCenterOfMassEndsBetweenTheFeetAtThePathsEnd) {
  WalkPattern pattern = Make();
  while (!pattern.Finished()) pattern.Advance({});
  const WalkTargets& end = pattern.targets();
  EXPECT_EQ(end.gait.step, -1);
  EXPECT_NEAR(end.posture.com.x(), 0.6 + 0.008, 0.003);  // 8 mm before the ankles; steps end within 2 mm
  EXPECT_NEAR(end.posture.com.y(), 0, 0.001);
}

TEST(WalkPattern, PlannedZmpStaysUnderTheSoles) {
  WalkPattern pattern = Make();
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    if (now.swing_phase < 0.1 || now.swing_phase > 0.9) continue;
    const Eigen::Vector2d foot = now.posture.X_PA[size_t(now.stance)].translation.head<2>();
    EXPECT_LT(std::abs(pattern.cart_zmp().y() - foot.y()), 0.03);  // half the sole's width
    EXPECT_LT(std::abs(pattern.cart_zmp().x() - foot.x() - 0.008), 0.05);
  }
}

/// Advances until the pattern stands where it was halted. @returns ticks.
int AdvanceUntilHalted(WalkPattern& pattern) {
  int ticks = 0;
  for (; !pattern.Halted(); ++ticks) {
    pattern.Advance({});
    if (ticks > 10000) break;
  }
  return ticks;
}

TEST(WalkPattern, HaltedItStandsWithItsFeetSideBySideAndGoesOnToThePathsEnd) {
  WalkPattern pattern = Make({}, 1.0);
  for (int tick = 0; tick < 700; ++tick) pattern.Advance({});
  pattern.Halt();
  // Within the steps that the preview of 1 s has seen, three more to slow down and the closing one, 0.35 s each.
  EXPECT_LT(AdvanceUntilHalted(pattern) * 0.004, (6 + 3 + 1) * 0.35);
  for (int tick = 0; tick < 500; ++tick) pattern.Advance({});
  const WalkTargets stop = pattern.targets();
  EXPECT_EQ(stop.gait.step, -1);
  EXPECT_FALSE(pattern.Finished());
  EXPECT_NEAR(stop.posture.X_PA[0].translation.x(), stop.posture.X_PA[1].translation.x(), 1e-9);
  EXPECT_NEAR(stop.posture.com.y(), 0, 0.001);
  EXPECT_GT(stop.posture.com.x(), 0.2);
  EXPECT_LT(stop.posture.com.x(), 0.8);
  pattern.GoOn({});
  WalkTargets last = pattern.targets();
  while (!pattern.Finished()) {
    const WalkTargets& now = pattern.Advance({});
    for (const int side : {0, 1}) {
      const Eigen::Vector3d moved = now.posture.X_PA[side].translation - last.posture.X_PA[side].translation;
      EXPECT_LT(moved.norm() / 0.004, 0.64);  // as in FeetMoveWithoutJumps
    }
    EXPECT_LT((now.posture.com - last.posture.com).norm() / 0.004, 0.3);
    last = now;
  }
  EXPECT_NEAR(last.posture.com.x(), 1.0 + 0.008, 0.003);
}

TEST(WalkPattern, BeforeItsFirstStepItIsPutOff) {
  WalkPattern pattern = Make();
  pattern.Advance({});
  pattern.Halt();
  EXPECT_TRUE(pattern.Halted());
  for (int tick = 0; tick < 1000; ++tick) {
    const WalkTargets& now = pattern.Advance({});
    EXPECT_EQ(now.gait.step, -1);
    EXPECT_LT(now.posture.com.norm(), 0.01);
  }
  pattern.GoOn({});
  while (!pattern.Finished()) pattern.Advance({});
  EXPECT_NEAR(pattern.targets().posture.com.x(), 0.6 + 0.008, 0.003);
}

TEST(WalkPattern, TurnsWhereItStandsAndBack) {
  WalkPattern pattern = Make();
  for (int tick = 0; tick < 500; ++tick) pattern.Advance({});
  pattern.Halt();
  AdvanceUntilHalted(pattern);
  const WalkTargets before = pattern.targets();
  for (const double turn : {3.0, -3.0}) {
    pattern.TurnOnTheSpot(turn, {});
    EXPECT_FALSE(pattern.Halted());
    AdvanceUntilHalted(pattern);
    EXPECT_NEAR(pattern.targets().posture.heading, before.posture.heading + std::max(0.0, turn), 0.025);
  }
  EXPECT_LT((pattern.targets().posture.com - before.posture.com).norm(), 0.01);
  pattern.GoOn({});
  while (!pattern.Finished()) pattern.Advance({});
  EXPECT_NEAR(pattern.targets().posture.com.x(), 0.6 + 0.008, 0.003);
}

}  // namespace
}  // namespace gaitcam
