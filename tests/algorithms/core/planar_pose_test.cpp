#include "algorithms/core/planar_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

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

TEST(PlanarCovariance, OfAnInvertedMotionIsThatOfManyDraws) {
  // As the floor's tracker has it: X_CR comes with a covariance, X_WR is known, X_WC = X_WR X_CR^-1 is asked for.
  RandomStream random(2, "draws");
  const Pose X_WR(RotZ(0.7) * RotX(-2.2) * RotZ(0.1), Eigen::Vector3d(1, 2, 0.3));
  const Pose X_CR(RotX(0.1) * RotY(-0.2), Eigen::Vector3d(0.05, -0.03, 0.2)), X_WC = X_WR * X_CR.Inverse();
  Matrix6d L;
  for (int i = 0; i < 36; ++i) L(i / 6, i % 6) = 0.002 * random.Normal();
  const Eigen::Matrix3d stated = PlanarCovariance(X_WC, CovarianceOfInverse(X_CR, L * L.transpose()));
  const Eigen::Matrix3d whiten = stated.llt().matrixL().toDenseMatrix().inverse();
  const double heading = BelowCamera(X_WC).heading;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    Vector6d z;
    for (int k = 0; k < 6; ++k) z[k] = random.Normal();
    const Pose drawn = X_WR * Plus(X_CR, L * z).Inverse();
    Eigen::Vector3d error;
    error << Rotate((drawn.translation - X_WC.translation).head<2>(), -heading),
        LogSo3(drawn.rotation * X_WC.rotation.conjugate()).z();
    error = whiten * error;
    sum += error * error.transpose();
  }
  // Five standard deviations, sqrt(2 / draws) each; errors of 0.005 rad leave a second order of 1e-4.
  EXPECT_LT((sum / kDraws - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.05);
}

TEST(PlanarMotion, MovesPointsAsItsPoseDoesToTheBit) {
  const PlanarPose pose({0.3, -1.7}, 2.1);
  const PlanarMotion motion(pose);
  for (const double x : {-2.0, 0.0, 0.7})
    EXPECT_EQ(motion * Eigen::Vector2d(x, 1 - x), pose * Eigen::Vector2d(x, 1 - x));
}

TEST(SpatialCovariance, HasThePlanarPartItWasGiven) {
  const Pose X_WC(RotZ(0.7) * RotY(0.4) * RotX(-1.2), Eigen::Vector3d(1, 2, 0.3));
  Eigen::Matrix3d planar;
  planar << 4, 1, 0.5, 1, 3, -0.2, 0.5, -0.2, 2;
  const Matrix6d covariance = SpatialCovariance(X_WC, planar, 0.1, 0.02);
  EXPECT_LT((PlanarCovariance(X_WC, covariance) - planar).norm(), 1e-12);
  const Eigen::Vector3d up_C = X_WC.R().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(up_C.dot(covariance.topLeftCorner<3, 3>() * up_C), 0.01, 1e-12) << "height";
  EXPECT_NEAR((covariance.bottomRightCorner<3, 3>().trace()), 2 + 2 * 0.0004, 1e-12)
      << "heading, and tilt about two axes";
}

TEST(PlanarAdjoint, CarriesAPerturbationToTheOtherSide) {
  const PlanarPose X({1, -2}, 0.8);
  const Eigen::Vector3d tau(1e-7, -2e-7, 3e-7), other = PlanarAdjoint(X) * tau;
  const PlanarPose right = X * PlanarPose(tau.head<2>(), tau[2]), left = PlanarPose(other.head<2>(), other[2]) * X;
  EXPECT_LT((right.position - left.position).norm(), 1e-12) << "of first order: what is left is of the order of tau^2";
  EXPECT_NEAR(right.heading, left.heading, 1e-15);
}

}  // namespace
}  // namespace gaitcam
