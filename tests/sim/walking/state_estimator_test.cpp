#include "sim/walking/state_estimator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

constexpr double kPeriod_s = 0.004;

class StateEstimatorTest : public testing::Test {
 protected:
  StateEstimatorTest()
      : robot_(ReadShippedRobot("khr1hv")),
        world_(robot_, Scene{}, PhysicsOptions{}, {}, 1),
        mass_(robot_, world_.nominal_model()),
        estimator_(robot_, {}, {Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 0.145)}),
        joints_(robot_.joints.size(), 0.0) {}

  /// The IMU's mount has the trunk's axes.
  void Feed(const Eigen::Vector3d& rate, const Eigen::Vector3d& force, double seconds, bool calibrate = false,
            int stance = -1) {
    for (double t = 0; t < seconds; t += kPeriod_s) {
      ImuSample imu;
      imu.angular_rate = rate;
      imu.specific_force = force;
      estimator_.Update(imu, joints_, kPeriod_s, stance, calibrate, mass_);
    }
  }

  Robot robot_;
  World world_;
  MassModel mass_;
  StateEstimator estimator_;
  std::vector<double> joints_;
};

TEST_F(StateEstimatorTest, IntegratesTheGyroscope) {
  // Gravity turns with the trunk, or the accelerometer would pull it back: feed one quick turn.
  Feed({0.5, 0, 0}, {0, 0, 9.81}, 0.1);
  EXPECT_NEAR(estimator_.roll(), 0.05, 0.002);
  EXPECT_NEAR(estimator_.pitch(), 0, 1e-3);
}

TEST_F(StateEstimatorTest, TheAccelerometerFindsTheVerticalInTheEnd) {
  // Leaning forward by 0.1 rad from the start: specific force points up in the world.
  const Eigen::Vector3d force = 9.81 * (RotY(0.1).transpose() * Eigen::Vector3d::UnitZ());
  Feed({0, 0, 0}, force, 60);
  EXPECT_NEAR(estimator_.pitch(), 0.1, 1e-3);
  EXPECT_NEAR(estimator_.roll(), 0, 1e-6);
}

TEST_F(StateEstimatorTest, LearnsTheGyroscopesBiasAtRest) {
  const Eigen::Vector3d bias(0.01, -0.02, 0.03);
  Feed(bias, {0, 0, 9.81}, 0.5, true);
  Feed(bias, {0, 0, 9.81}, 5.0, false);
  EXPECT_NEAR(estimator_.angular_rate().norm(), 0, 1e-12);
  EXPECT_NEAR(estimator_.X_OB().Yaw(), 0, 2e-3);  // learnt from the first sample on
}

TEST_F(StateEstimatorTest, SeesTheCenterOfMassOverEachFoot) {
  Feed({0, 0, 0}, {0, 0, 9.81}, 0.1);
  const Eigen::Vector3d com = mass_.CenterOfMass(joints_);
  for (const int side : {0, 1}) {
    const Eigen::Vector3d ankle = LegKinematics(robot_, side).Forward({}).translation;
    const ComOverFoot& seen = estimator_.com_over_foot(side);
    EXPECT_NEAR((seen.position - (com - ankle).head<2>()).norm(), 0, 1e-9);
    EXPECT_NEAR(seen.velocity.norm(), 0, 1e-9);
  }
}

TEST_F(StateEstimatorTest, TippingOverTheStandingFootIsSeenAsMotionOfTheCenterOfMass) {
  Feed({0, 0.3, 0}, {0, 0, 9.81}, 0.2, false, 0);
  // It turns about the ankle: speed = rate x height of the centre of mass over it.
  const double height = mass_.CenterOfMass(joints_).z() - LegKinematics(robot_, 0).Forward({}).translation.z();
  EXPECT_NEAR(estimator_.com_over_foot(0).velocity.x(), 0.3 * height, 0.1 * 0.3 * height);
}

TEST_F(StateEstimatorTest, LegOdometryMovesOverTheFootThatStands) {
  const LegKinematics left(robot_, 0), right(robot_, 1);
  const auto place = [&](double left_x, double right_x) {
    for (const LegKinematics* leg : {&left, &right}) {
      const double x = leg == &left ? left_x : right_x;
      const Pose X_BA(Eigen::Matrix3d::Identity(), leg->hip() + Eigen::Vector3d(x, 0, -0.115));
      leg->ToJoints(leg->Inverse(X_BA).angles, joints_);
    }
  };
  place(0, 0);
  Feed({0, 0, 0}, {0, 0, 9.81}, 0.02, false, 0);
  const double begin = estimator_.X_OB().translation.x();
  // The trunk passes 20 mm over the left foot while the right one swings forward; then over the right one.
  place(-0.02, 0.03);
  Feed({0, 0, 0}, {0, 0, 9.81}, 0.02, false, 0);
  EXPECT_NEAR(estimator_.X_OB().translation.x() - begin, 0.02, 1e-9);
  Feed({0, 0, 0}, {0, 0, 9.81}, 0.004, false, 1);
  place(0.03, -0.02);
  Feed({0, 0, 0}, {0, 0, 9.81}, 0.02, false, 1);
  EXPECT_NEAR(estimator_.X_OB().translation.x() - begin, 0.07, 1e-9);
}

}  // namespace
}  // namespace gaitcam
