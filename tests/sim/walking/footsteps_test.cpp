#include "sim/walking/footsteps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

Path MakePath(PathKind kind, double length_m = 1.0) {
  PathOptions options;
  options.kind = kind;
  options.length_m = length_m;
  options.side_m = 0.5;
  options.diameter_m = 1.0;
  return {options, {}};
}

TEST(Footsteps, AlternateBetweenTheFeet) {
  FootstepPlanner planner({}, {}, MakePath(PathKind::kStraight));
  while (!planner.complete()) planner.Append({}, planner.count());
  for (int i = 0; i < planner.count(); ++i) EXPECT_EQ(planner.print(i).side, i % 2);
}

TEST(Footsteps, EndSideBySideAtThePathsEnd) {
  for (const PathKind kind : {PathKind::kStraight, PathKind::kCircle, PathKind::kSquare, PathKind::kThereAndBack}) {
    const Path path = MakePath(kind);
    FootstepPlanner planner({}, {}, path);
    while (!planner.complete()) {
      planner.Append({}, planner.count());
      ASSERT_LT(planner.count(), 2000) << ToWord(kind);
    }
    const PlanarPose last = planner.Center(planner.print(planner.count() - 1));
    const PlanarPose before = planner.Center(planner.print(planner.count() - 2));
    EXPECT_NEAR((last.position - before.position).norm(), 0, 1e-12) << ToWord(kind);
    // Steering is proportional, so a small error of the last corner remains; along the way steps end within 2 mm.
    EXPECT_NEAR((last.position - path.goal().position).norm(), 0, 0.005) << ToWord(kind);
    EXPECT_NEAR(last.heading, path.goal().heading, 0.02) << ToWord(kind);
  }
}

TEST(Footsteps, StartAndStopInRamps) {
  const GaitOptions gait;
  FootstepPlanner planner(gait, {}, MakePath(PathKind::kStraight));
  while (!planner.complete()) planner.Append({}, planner.count());
  double length = 0;
  for (int i = 2; i < planner.count(); ++i) {
    const double next =
        (planner.Center(planner.print(i)).position - planner.Center(planner.print(i - 1)).position).norm();
    EXPECT_LE(next, gait.step_length_m + 1e-12);
    EXPECT_LE(next - length, 0.25 * gait.step_length_m + 1e-9) << "step " << i;
    EXPECT_GE(next - length, -0.5 * gait.step_length_m) << "step " << i;  // the last one closes the feet
    length = next;
  }
}

TEST(Footsteps, KeepTheirSpacing) {
  const GaitOptions gait;
  FootstepPlanner planner(gait, {}, MakePath(PathKind::kCircle));
  while (!planner.complete()) planner.Append({}, planner.count());
  for (int i = 1; i < planner.count(); ++i) {
    const PlanarPose between = planner.print(i - 1).ankle.Inverse() * planner.print(i).ankle;
    const double sideways = SideSign(planner.print(i).side) * between.position.y();
    EXPECT_NEAR(sideways, gait.foot_spacing_m, 0.25 * gait.foot_spacing_m);
  }
}

TEST(Footsteps, NeverTurnMoreThanAllowed) {
  SteeringOptions steering;
  steering.max_turn_rad = 0.15;
  FootstepPlanner planner({}, steering, MakePath(PathKind::kThereAndBack));
  while (!planner.complete()) planner.Append({}, planner.count());
  for (int i = 1; i < planner.count(); ++i) {
    EXPECT_LE(std::abs(planner.print(i).ankle.heading - planner.print(i - 1).ankle.heading), 0.15 + 1e-12);
  }
}

TEST(Footsteps, AsymmetryLengthensLeftStepsAlone) {
  GaitOptions gait;
  gait.asymmetry_ratio = 0.2;
  FootstepPlanner planner(gait, {}, MakePath(PathKind::kStraight, 3.0));
  while (!planner.complete()) planner.Append({}, planner.count());
  for (int i = 20; i < 40; ++i) {
    const double length = planner.print(i).ankle.position.x() - planner.print(i - 1).ankle.position.x();
    EXPECT_NEAR(length, planner.print(i).side == 0 ? 0.048 : 0.032, 1e-9);
  }
}

/// Walks 8 m while slipping feet turn the plan in the world by `slip_rad` a step, the queue being 8 steps long.
/// @returns how far from the line the robot ever is, once it has settled.
double WorstOffset(double slip_rad, bool slip_is_known) {
  FootstepPlanner planner({}, {}, MakePath(PathKind::kStraight, 8.0));
  PlanDrift drift;
  double worst = 0;
  for (int walked = 1; !planner.complete(); ++walked) {
    while (!planner.complete() && planner.count() < walked + 8) planner.Append(drift, walked);
    const PlanarPose here_P = planner.Center(planner.print(walked));
    const PlanarPose here_W = drift.X_WP * here_P;
    // The world turns about the robot, not about the plan's origin.
    const double heading = drift.X_WP.heading + slip_rad;
    drift.X_WP = {here_W.position - PlanarPose({0, 0}, heading) * here_P.position, heading};
    if (slip_is_known) drift.slip_rad = slip_rad;
    if (walked > 60) worst = std::max(worst, std::abs(here_W.position.y()));
  }
  return worst;
}

TEST(Footsteps, SteeringHoldsTheLineAlthoughTheQueueIsLong) {
  // A proportional law balances 0.01 rad a step at 0.01 / heading_gain rad plus the queue's 0.08 rad of heading,
  // that is at about 0.11 m beside the line; swinging up from dead time would show as far more.
  EXPECT_LT(WorstOffset(0.01, false), 0.13);
}

TEST(Footsteps, SlipThatIsKnownIsSteeredAgainst) { EXPECT_LT(WorstOffset(0.01, true), 0.01); }

TEST(Footsteps, ForgetsWhatHasBeenWalked) {
  FootstepPlanner planner({}, {}, MakePath(PathKind::kStraight));
  for (int i = 0; i < 10; ++i) planner.Append({}, planner.count());
  const PlanarPose kept = planner.print(7).ankle;
  planner.Forget(7);
  EXPECT_EQ(planner.count(), 12);
  EXPECT_EQ(planner.print(7).ankle.position, kept.position);
  EXPECT_THROW(planner.print(6), std::logic_error);
}

TEST(Footsteps, StandingNeedsNoSteps) { EXPECT_TRUE(FootstepPlanner({}, {}, MakePath(PathKind::kStand)).complete()); }

}  // namespace
}  // namespace gaitcam
