#include "algorithms/odometry/keyframe_policy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

constexpr double kFar_px = 20;
constexpr int kMinInliers = 15;

constexpr int64_t kInterval_ns = 100'000'000;  // of 10 frames/s

/// So long until a frame is taken as keyframe, each `frame`, s; -1: none in ten seconds.
double WaitUntilKeyframe_s(KeyframePolicy policy, const SinceKeyframe& frame, int64_t interval_ns = kInterval_ns) {
  for (int64_t waited_ns = 0; waited_ns < 10'000'000'000; waited_ns += interval_ns) {
    if (policy.IsKeyframe(kInterval_ns + waited_ns, frame)) return 1e-9 * double(waited_ns);
  }
  return -1;
}

/// After a frame with many inliers.
KeyframePolicy AfterAGoodFrame() {
  KeyframePolicy policy({}, kMinInliers);
  policy.IsKeyframe(0, {0, 0, 400, true});
  return policy;
}

TEST(KeyframePolicy, NothingIsDueWhileTheCameraStaysWhereItWas) {
  EXPECT_EQ(WaitUntilKeyframe_s(AfterAGoodFrame(), {1, 0, 400, true}), -1);
}

TEST(KeyframePolicy, ADueKeyframeIsTheFirstThatIsSharpAndSeesWell) {
  EXPECT_EQ(WaitUntilKeyframe_s(AfterAGoodFrame(), {kFar_px, 0, 400, true}), 0);
}

// Once it has waited long enough, one of both will do; and where neither comes, anything. At each frame rate a time,
// but for the interval at which it is asked.
TEST(KeyframePolicy, ADueKeyframeWaitsLongestForABlurredFrameOfFewInliers) {
  const double wait_s = KeyframePolicyOptions().max_wait_s;
  for (const double rate_hz : {5.0, 10.0, 30.0, 100.0}) {
    const int64_t interval_ns = std::llround(1e9 / rate_hz);
    const auto expect_within_a_frame = [&](const SinceKeyframe& frame, double expected_s) {
      const double waited_s = WaitUntilKeyframe_s(AfterAGoodFrame(), frame, interval_ns);
      EXPECT_GE(waited_s, expected_s) << rate_hz;
      EXPECT_LT(waited_s, expected_s + 1 / rate_hz) << rate_hz;
    };
    expect_within_a_frame({kFar_px, 0, 400, false}, wait_s);
    expect_within_a_frame({kFar_px, 0, 100, true}, wait_s);
    expect_within_a_frame({kFar_px, 0, 100, false}, 2 * wait_s);
  }
}

TEST(KeyframePolicy, OneThatIsNearlyLostDoesNotWait) {
  EXPECT_EQ(WaitUntilKeyframe_s(AfterAGoodFrame(), {kFar_px, 0, 2 * kMinInliers - 1, false}), 0);
}

TEST(KeyframePolicy, TheWaitBeginsAnewAfterAKeyframe) {
  KeyframePolicy policy = AfterAGoodFrame();
  EXPECT_GT(WaitUntilKeyframe_s(policy, {kFar_px, 0, 100, true}), 0);
  EXPECT_FALSE(policy.IsKeyframe(kInterval_ns, {kFar_px, 0, 100, true})) << "begins to wait";
  policy.OnKeyframe(400);
  EXPECT_FALSE(policy.IsKeyframe(20 * kInterval_ns, {0, 0, 400, true}));
  EXPECT_FALSE(policy.IsKeyframe(21 * kInterval_ns, {kFar_px, 0, 100, true}));
}

}  // namespace
}  // namespace gaitcam
