#include "results/scoring/jumps.h"

#include <gtest/gtest.h>

#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

const Trajectory kTruth = SwayingCircle(200, 1, 3);

std::vector<Jump> JumpsAfter(size_t at, const Eigen::Vector3d& shift_m, double turn_deg) {
  Trajectory estimate = kTruth;
  for (size_t i = at; i < estimate.size(); ++i) {
    estimate[i].pose.translation += shift_m;
    estimate[i].pose.rotation = estimate[i].pose.rotation * Eigen::Quaterniond(RotY(turn_deg / 180 * std::numbers::pi));
  }
  return FindJumps(PairUp(kTruth, estimate));
}

TEST(Jumps, OfATrueTrajectoryThereAreNone) { EXPECT_TRUE(FindJumps(PairUp(kTruth, kTruth)).empty()); }

TEST(Jumps, AStepOfFiveCentimetresIsFoundWhereItIs) {
  const std::vector<Jump> jumps = JumpsAfter(77, {0, 0.05, 0}, 0);
  ASSERT_EQ(jumps.size(), 1u);
  EXPECT_EQ(jumps[0].to, 77u);
  EXPECT_NEAR(jumps[0].position_m, 0.05, 1e-9);
  EXPECT_EQ(JumpsAfter(77, {0, 0.015, 0}, 0).size(), 0u);
}

TEST(Jumps, SoIsATurn) {
  EXPECT_EQ(JumpsAfter(77, {0, 0, 0}, 4).size(), 1u);
  EXPECT_EQ(JumpsAfter(77, {0, 0, 0}, 1.5).size(), 0u);
}

TEST(Jumps, NoiseAsATrackerHasItIsNone) {
  RandomStream random(1, "jumps");
  EXPECT_TRUE(FindJumps(PairUp(kTruth, Noisy(kTruth, random, 0.002, 0.001))).empty());
}

// After two seconds without a pose an estimate may be off by a part of what was walked meanwhile.
TEST(Jumps, TheAllowanceGrowsWithTheTrueMotion) {
  Trajectory estimate = kTruth;
  for (size_t i = 120; i < estimate.size(); ++i) estimate[i].pose.translation.x() += 0.05;
  std::vector<PosePair> pairs = PairUp(kTruth, estimate);
  EXPECT_EQ(FindJumps(pairs).size(), 1u);
  pairs.erase(pairs.begin() + 90, pairs.begin() + 120);
  EXPECT_TRUE(FindJumps(pairs).empty());
}

}  // namespace
}  // namespace gaitcam
