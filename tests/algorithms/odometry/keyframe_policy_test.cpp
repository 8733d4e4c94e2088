#include "algorithms/odometry/keyframe_policy.h"

#include <gtest/gtest.h>

namespace gaitcam {
namespace {

constexpr double kFar_px = 20;
constexpr int kMinInliers = 15;

/// So many frames until one is taken as keyframe, each `frame`; 0: none of a hundred.
int FramesUntilKeyframe(KeyframePolicy policy, const SinceKeyframe& frame) {
  for (int i = 1; i <= 100; ++i) {
    if (policy.IsKeyframe(frame)) return i;
  }
  return 0;
}

/// After a frame with many inliers.
KeyframePolicy AfterAGoodFrame() {
  KeyframePolicy policy({}, kMinInliers);
  policy.IsKeyframe({0, 0, 400, true});
  return policy;
}

TEST(KeyframePolicy, NothingIsDueWhileTheCameraStaysWhereItWas) {
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {1, 0, 400, true}), 0);
}

TEST(KeyframePolicy, ADueKeyframeIsTheFirstThatIsSharpAndSeesWell) {
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {kFar_px, 0, 400, true}), 1);
}

// Once it has waited long enough, one of both will do; and where neither comes, anything.
TEST(KeyframePolicy, ADueKeyframeWaitsLongestForABlurredFrameOfFewInliers) {
  const KeyframePolicyOptions options;
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {kFar_px, 0, 400, false}), options.max_wait_frames + 1);
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {kFar_px, 0, 100, true}), options.max_wait_frames + 1);
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {kFar_px, 0, 100, false}), 2 * options.max_wait_frames + 1);
}

TEST(KeyframePolicy, OneThatIsNearlyLostDoesNotWait) {
  EXPECT_EQ(FramesUntilKeyframe(AfterAGoodFrame(), {kFar_px, 0, 2 * kMinInliers - 1, false}), 1);
}

}  // namespace
}  // namespace gaitcam
