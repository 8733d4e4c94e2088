#include "algorithms/core/pose.h"

#include <gtest/gtest.h>

#include <numbers>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

Pose RandomPose(RandomStream& random) {
  const Eigen::Quaterniond q(random.Normal(), random.Normal(), random.Normal(), random.Normal());
  return {q, Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal())};
}

TEST(Pose, ComposesAsItsMatrixDoes) {
  RandomStream random(2, "pose_test");
  for (int i = 0; i < 100; ++i) {
    const Pose a = RandomPose(random), b = RandomPose(random);
    EXPECT_LT(((a * b).Matrix() - a.Matrix() * b.Matrix()).norm(), 1e-13);
    EXPECT_LT(((a * a.Inverse()).Matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-13);
  }
}

TEST(Pose, InterpolationMeetsBothEndsAndHalvesTheAngle) {
  RandomStream random(3, "pose_test");
  const Pose a = RandomPose(random), b = RandomPose(random);
  EXPECT_LT((Interpolate(a, b, 0).Matrix() - a.Matrix()).norm(), 1e-13);
  EXPECT_LT((Interpolate(a, b, 1).Matrix() - b.Matrix()).norm(), 1e-13);
  const Pose middle = Interpolate(a, b, 0.5);
  EXPECT_NEAR(RotationAngle(a.rotation, middle.rotation), 0.5 * RotationAngle(a.rotation, b.rotation), 1e-12);
}

TEST(Angles, WrapIntoOneTurn) {
  EXPECT_NEAR(WrapAngle(3 * std::numbers::pi / 2), -std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(WrapAngle(-7.0), -7.0 + 2 * std::numbers::pi, 1e-15);
  EXPECT_DOUBLE_EQ(WrapAngle(-std::numbers::pi), std::numbers::pi);
}

}  // namespace
}  // namespace gaitcam
