#include "algorithms/core/planar_pose.h"

#include <gtest/gtest.h>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

TEST(PlanarPose, ComposesAndInvertsAsTheRigidMotionsDo) {
  RandomStream random(1, "poses");
  for (int i = 0; i < 50; ++i) {
    const auto draw = [&] {
      const double x = random.Normal(), y = random.Normal(), yaw = random.Uniform(-3, 3);
      return PlanarPose{{x, y}, yaw};
    };
    const PlanarPose a = draw(), b = draw();
    EXPECT_NEAR(((a * b).Lifted().Matrix() - (a.Lifted() * b.Lifted()).Matrix()).norm(), 0, 1e-12);
    EXPECT_NEAR((a.Inverse().Lifted().Matrix() - a.Lifted().Inverse().Matrix()).norm(), 0, 1e-12);
    const Eigen::Vector2d p(0.3, -2);
    EXPECT_NEAR(((a * p) - (a.Lifted() * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>()).norm(), 0, 1e-12);
  }
}

TEST(BelowCamera, LeavesHeightAndTiltAlone) {
  const Pose X_WC(RotZ(0.7) * RotX(-2.2) * RotZ(0.1), Eigen::Vector3d(1, 2, 0.3));
  const PlanarPose below = BelowCamera(X_WC);
  const Pose rest = below.Inverse().Lifted() * X_WC;
  EXPECT_NEAR(rest.translation.head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR(rest.translation.z(), 0.3, 1e-12);
  const Eigen::Vector3d forward = rest.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(forward.y(), 0, 1e-12);  // it looks along x
  EXPECT_GT(forward.x(), 0);
}

}  // namespace
}  // namespace gaitcam
