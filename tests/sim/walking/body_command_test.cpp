// Robots that a system commands, in physics: they walk as fast as they are told, and come to where they are sent.

#include "algorithms/core/body_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/walking/omni_drive.h"
#include "sim/walking/walker.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

/// A robot on an empty floor without cameras, standing at the world's origin with its path ahead.
class CommandedRobot {
 public:
  explicit CommandedRobot(const std::string& name, const PathOptions& path = {})
      : robot_(ReadShippedRobot(name)), path_(path), world_(robot_, Floor(), physics_, {}, 1) {
    if (robot_.kind == Robot::Kind::kOmniBase) {
      controller_ = MakeOmniDrive(robot_, drive_, path, {});
    } else {
      const GaitOptions& gait = robot_.gaits.at("normal");
      world_.ScaleServos(gait.servo_stiffness, gait.neck_stiffness);
      controller_ = MakeWalker(robot_, world_.nominal_model(), gait, path, physics_, {});
    }
    world_.SetState(controller_->InitialRoot(), controller_->InitialJoints());
    sensors_.emplace(world_, SensorOptions(), 1);
  }

  /// Serves a command, which is repeated at every period as a system repeats it. @returns false if the robot fell.
  bool Serve(const BodyCommand& command, double seconds) {
    const double until = time_s() + seconds;
    while (time_s() < until && !controller_->Finished()) {
      controller_->Command(command);
      ControlInput input{world_.stamp_ns(), sensors_->imu(), sensors_->ReadJoints(world_), world_.X_WB()};
      world_.SetTargets(controller_->Update(input));
      const int64_t next = world_.stamp_ns() + world_.control_period_ns();
      while (world_.stamp_ns() < next) {
        world_.Step();
        sensors_->Step(world_);
      }
      sensors_->TakeImu();
      world_.record().DropBefore(world_.stamp_ns());
      const double yaw = world_.X_WB().Yaw();
      turned_rad_ += WrapAngle(yaw - yaw_);
      yaw_ = yaw;
      if (world_.HasFallen()) return false;
    }
    return true;
  }

  double time_s() const { return 1e-9 * double(world_.stamp_ns()); }
  double turned_rad() const { return turned_rad_; }
  PlanarPose root() const { return PlanarPose(world_.X_WB()); }
  const Controller& controller() const { return *controller_; }
  const GaitOptions& gait() const { return robot_.gaits.at("normal"); }
  PlanarPose path_goal() const { return Path(path_, {}).goal(); }

 private:
  static Scene Floor() {
    Scene scene;
    scene.name = "empty";
    scene.floor_min = {-100, -100};
    scene.floor_max = {100, 100};
    return scene;
  }

  Robot robot_;
  PathOptions path_;
  PhysicsOptions physics_;
  OmniDriveOptions drive_;
  World world_;
  std::unique_ptr<Controller> controller_;
  std::optional<SensorSuite> sensors_;
  double yaw_ = 0, turned_rad_ = 0;
};

TEST(OmniBaseCommands, VelocityIsDriven) {
  CommandedRobot base("omni_base");
  ASSERT_TRUE(base.Serve(Velocity{0.1, -0.05, 0}, 6));
  // It gets up to 0.11 m/s at 0.3 m/s^2: half of those 0.37 s is lost.
  const double driven_s = 6 - 0.5 * std::hypot(0.1, 0.05) / 0.3;
  EXPECT_NEAR(base.root().position.x(), 0.1 * driven_s, 0.005);
  EXPECT_NEAR(base.root().position.y(), -0.05 * driven_s, 0.005);
  EXPECT_NEAR(base.turned_rad(), 0, 0.005);
}

TEST(OmniBaseCommands, VelocityIsTheRobotsOwnAndClamped) {
  CommandedRobot base("omni_base");
  ASSERT_TRUE(base.Serve(Velocity{0, 0, 0.5}, 4));
  const double turned = 0.5 * (4 - 0.5 * 0.5 / 1.0);  // 1 rad/s^2
  EXPECT_NEAR(base.turned_rad(), turned, 0.01);
  ASSERT_TRUE(base.Serve(Velocity(), 1.5));
  const PlanarPose stood = base.root();
  ASSERT_TRUE(base.Serve(Velocity{5, 0, 0}, 3));  // 0.2 m/s are its most
  const Eigen::Vector2d way = stood.Inverse() * base.root().position;
  EXPECT_NEAR(way.x(), 0.2 * (3 - 0.5 * 0.2 / 0.3), 0.01);
  EXPECT_NEAR(way.y(), 0, 0.01);
}

TEST(OmniBaseCommands, AGoalIsReachedAndThePathFollowedToItsEndAfterwards) {
  PathOptions path;
  path.length_m = 0.6;
  CommandedRobot base("omni_base", path);
  ASSERT_TRUE(base.Serve(FollowPath(), 2.5));
  const PlanarPose left_at = base.root();
  ASSERT_TRUE(base.Serve(GoTo{0.3, 0.4, 2.0}, 12));
  const PlanarPose reached = left_at.Inverse() * base.root();
  // It rolls on a little while it comes to a halt, and knows that.
  EXPECT_NEAR((reached.position - Eigen::Vector2d(0.3, 0.4)).norm(), 0, 0.01);
  EXPECT_NEAR(WrapAngle(reached.heading - 2.0), 0, 0.01);
  EXPECT_FALSE(base.controller().Finished());
  ASSERT_TRUE(base.Serve(FollowPath(), 60));
  EXPECT_TRUE(base.controller().Finished());
  EXPECT_NEAR((base.root().position - base.path_goal().position).norm(), 0, 0.002);
  EXPECT_NEAR(base.root().heading, base.path_goal().heading, 0.002);
}

TEST(HumanoidCommands, ZeroVelocityFromTheBeginningStands) {
  CommandedRobot robot("khr1hv");
  ASSERT_TRUE(robot.Serve(Velocity(), 5));
  EXPECT_EQ(robot.controller().gait().step, -1);
  EXPECT_LT(robot.root().position.norm(), 0.01);
  EXPECT_FALSE(robot.controller().Finished());
}

struct VelocityCase {
  Velocity velocity;
  const char* name;
};

class HumanoidVelocity : public testing::TestWithParam<VelocityCase> {};

TEST_P(HumanoidVelocity, IsWalkedWithoutAFall) {
  constexpr double kWalk_s = 16, kBegin_s = 3;
  const Velocity v = GetParam().velocity;
  CommandedRobot robot("khr1hv");
  ASSERT_TRUE(robot.Serve(v, kBegin_s));  // until steps have their full length
  const PlanarPose from = robot.root();
  const double turned = robot.turned_rad();
  ASSERT_TRUE(robot.Serve(v, kWalk_s));
  EXPECT_NEAR(robot.turned_rad() - turned, v.turn_rad_s * kWalk_s, 0.15 + 0.1 * std::abs(v.turn_rad_s) * kWalk_s);
  if (v.turn_rad_s == 0) {
    const Eigen::Vector2d way = from.Inverse() * robot.root().position;
    const Eigen::Vector2d wanted = kWalk_s * Eigen::Vector2d(v.forward_mps, v.left_mps);
    // Nothing corrects the steps' length: feet that slide on as they land make it up to a quarter longer.
    EXPECT_NEAR((way - wanted).norm(), 0, 0.02 + 0.25 * wanted.norm()) << way.transpose();
  }
  ASSERT_TRUE(robot.Serve(Velocity(), 4));
  EXPECT_EQ(robot.controller().gait().step, -1);  // it stands
  const PlanarPose stood = robot.root();
  ASSERT_TRUE(robot.Serve(Velocity(), 2));
  EXPECT_LT((robot.root().position - stood.position).norm(), 0.003);
}

INSTANTIATE_TEST_SUITE_P(, HumanoidVelocity,
                         testing::Values(VelocityCase{{0.06, 0, 0}, "Forward"}, VelocityCase{{-0.03, 0, 0}, "Backward"},
                                         VelocityCase{{0, 0.015, 0}, "Left"}, VelocityCase{{0, -0.015, 0}, "Right"},
                                         VelocityCase{{0, 0, 0.25}, "TurningLeft"},
                                         VelocityCase{{0.05, 0, -0.2}, "OnAnArc"}),
                         [](const auto& info) { return info.param.name; });

TEST(HumanoidCommands, AVelocityBeyondTheGaitIsClampedToItsLongestStep) {
  CommandedRobot robot("khr1hv");
  ASSERT_TRUE(robot.Serve(Velocity{2, 0, 0}, 3));
  const PlanarPose from = robot.root();
  ASSERT_TRUE(robot.Serve(Velocity{2, 0, 0}, 10));
  const double way = (from.Inverse() * robot.root().position).x(),
               most = 10 * robot.gait().step_length_m / robot.gait().period_s;
  EXPECT_NEAR(way, most, 0.25 * most);  // feet slide, see above
}

TEST(HumanoidCommands, OneVelocityFollowsAnotherAndThePathAfterThem) {
  PathOptions path;
  path.length_m = 2.5;
  CommandedRobot robot("khr1hv", path);
  ASSERT_TRUE(robot.Serve(FollowPath(), 4));
  ASSERT_TRUE(robot.Serve(Velocity{0.05, 0, 0.15}, 6));
  ASSERT_TRUE(robot.Serve(Velocity{0, 0.015, 0}, 5));
  ASSERT_TRUE(robot.Serve(Velocity{0.05, 0, -0.15}, 5));
  ASSERT_TRUE(robot.Serve(FollowPath(), 60));
  EXPECT_TRUE(robot.controller().Finished());
  EXPECT_NEAR(robot.root().position.x(), path.length_m, 0.04);
  EXPECT_NEAR(robot.root().position.y(), 0, 0.05);
}

TEST(HumanoidCommands, AGoalIsReachedWithinFiveCentimetres) {
  PathOptions path;
  path.length_m = 3;
  CommandedRobot robot("khr1hv", path);
  ASSERT_TRUE(robot.Serve(GoTo{0.3, 0.25, -0.8}, 40));
  EXPECT_EQ(robot.controller().gait().step, -1);
  EXPECT_NEAR((robot.root().position - Eigen::Vector2d(0.3, 0.25)).norm(), 0, 0.05);
  EXPECT_NEAR(WrapAngle(robot.root().heading + 0.8), 0, 0.1);
  // Relative to where it stands now; the root sways by some millimetres.
  const PlanarPose from = robot.root();
  ASSERT_TRUE(robot.Serve(GoTo{0.2, 0, 0}, 20));
  EXPECT_NEAR((from.Inverse() * robot.root().position - Eigen::Vector2d(0.2, 0)).norm(), 0, 0.05);
}

}  // namespace
}  // namespace gaitcam
