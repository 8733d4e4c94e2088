#include "algorithms/odometry/mean_velocity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

constexpr int64_t kFrame_ns = 100'000'000, kSecond_ns = 1'000'000'000;

/// A walk of 25 cm/s along x that sways by 2 cm, at up to 18 cm/s, once in the 0.7 s of a double step.
StampedPose Walking(int frame) {
  const double t_s = 1e-9 * double(frame * kFrame_ns);
  const Eigen::Vector3d at(0.25 * t_s, 0.02 * std::sin(2 * M_PI / 0.7 * t_s), 0);
  return {frame * kFrame_ns, Pose(Eigen::Quaterniond::Identity(), at)};
}

TEST(MeanVelocity, IsTheWalksWithoutItsSway) {
  MeanVelocity velocity;
  double worst = 0;
  for (int frame = 0; frame < 100; ++frame) {
    velocity.Add(Walking(frame));
    if (frame < 50) continue;  // e^-5 of what it began with is left
    worst = std::max(worst, (velocity.Advance(kFrame_ns) - Eigen::Vector3d(0.025, 0, 0)).norm());
  }
  // A low pass of 1 s leaves 1 / sqrt(1 + (2 pi / 0.7)^2) = 11 % of the sway's 18 cm/s: 2 mm in 0.1 s.
  EXPECT_LT(worst, 0.0025);
}

TEST(MeanVelocity, IsUnknownAtFirstAndAfterAReset) {
  MeanVelocity velocity;
  EXPECT_EQ(velocity.Advance(kFrame_ns), Eigen::Vector3d::Zero());
  for (int frame = 0; frame < 20; ++frame) velocity.Add(Walking(frame));
  EXPECT_GT(velocity.Advance(kFrame_ns).norm(), 0.02);
  velocity.Reset();
  EXPECT_EQ(velocity.Advance(kFrame_ns), Eigen::Vector3d::Zero());
  velocity.Add(Walking(200));  // somewhere else altogether
  EXPECT_EQ(velocity.Advance(kFrame_ns), Eigen::Vector3d::Zero());
}

TEST(MeanVelocity, IsUnknownAfterAGap) {
  MeanVelocity velocity;
  for (int frame = 0; frame < 20; ++frame) velocity.Add(Walking(frame));
  velocity.Add(Walking(24));  // a few frames that got no pose are no gap
  EXPECT_GT(velocity.Advance(kFrame_ns).norm(), 0.02);
  velocity.Add(Walking(30));
  EXPECT_EQ(velocity.Advance(kFrame_ns), Eigen::Vector3d::Zero());
}

TEST(MeanVelocity, GoesNoFartherThanInHalfASecond) {
  MeanVelocity velocity;
  for (int frame = 0; frame < 20; ++frame) velocity.Add(Walking(frame));
  EXPECT_EQ(velocity.Advance(kSecond_ns), velocity.Advance(kSecond_ns / 2));
  EXPECT_EQ(velocity.Advance(10 * kSecond_ns), velocity.Advance(kSecond_ns / 2));
}

}  // namespace
}  // namespace gaitcam
