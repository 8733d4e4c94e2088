#include "results/scoring/walked_path.h"

#include <gtest/gtest.h>

#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

/// Along x at 0.15 m/s for 20 s at 30 Hz, with a sway of 2 cm aside and 1 cm up and down at twice its frequency.
std::vector<PosePair> Walk(double gait_cycle_s, double sway_m) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 600; ++i) {
    const double t = i / 30.0, phase = 2 * std::numbers::pi * t / gait_cycle_s;
    const Eigen::Vector3d p(0.15 * t, sway_m * std::sin(phase), 0.3 + 0.5 * sway_m * std::sin(2 * phase));
    const Pose pose(LookAlong(0), p);
    pairs.push_back({int64_t(std::llround(1e9 * t)), pose, pose, {}});
  }
  return pairs;
}

TEST(WalkedPath, OfASteadyStraightWalkIsItsLength) {
  const std::vector<double> gone = WalkedPath(Walk(0.7, 0));
  for (size_t i = 0; i < gone.size(); ++i) EXPECT_NEAR(gone[i], 0.15 * double(i) / 30, 1e-9);
}

// Gait cycles of all shipped robots at their normal and brisk gaits, and a slower one.
TEST(WalkedPath, LeavesTheSwayOut) {
  for (const double gait_cycle_s : {0.6, 0.7, 0.96, 1.2}) {
    const std::vector<PosePair> pairs = Walk(gait_cycle_s, 0.02);
    EXPECT_GT(WalkedPath(pairs, 0).back(), 1.15 * 3) << gait_cycle_s;  // what the camera goes
    EXPECT_NEAR(WalkedPath(pairs).back(), 3, 0.03 * 3) << gait_cycle_s;
  }
}

TEST(WalkedPath, WhoStandsAndSwaysHardlyWalks) {
  std::vector<PosePair> pairs = Walk(0.7, 0.02);
  for (PosePair& pair : pairs) pair.truth.translation.x() = 0;
  EXPECT_GT(WalkedPath(pairs, 0).back(), 2);
  EXPECT_LT(WalkedPath(pairs).back(), 0.1);
}

TEST(WalkedPath, KeepsACirclesLength) {
  std::vector<PosePair> pairs = Walk(0.7, 0);
  for (PosePair& pair : pairs) {  // of 1 m, at 0.15 m/s
    const double angle = pair.truth.translation.x() / 0.5;
    pair.truth.translation = {0.5 * std::cos(angle), 0.5 * std::sin(angle), 0};
  }
  EXPECT_NEAR(WalkedPath(pairs).back(), 3, 0.02 * 3);  // a window of 2 s is 0.6 rad of the circle
}

TEST(WalkedPath, OfNothingIsNothing) {
  EXPECT_TRUE(WalkedPath({}).empty());
  EXPECT_EQ(WalkedPath({{0, Pose(), Pose(), {}}}), std::vector<double>{0});
}

}  // namespace
}  // namespace gaitcam
