#include "sim/world/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

Robot Shipped(const std::string& name = "khr1hv") { return ReadRobot(name, kModels); }

/// Knees bent by 0.96 rad, soles level.
std::vector<double> Crouch(const Robot& robot) {
  std::vector<double> joints(robot.joints.size(), 0.0);
  for (const RobotLeg& leg : robot.legs) {
    joints[leg.joints[2]] = joints[leg.joints[4]] = -0.48;
    joints[leg.joints[3]] = 0.96;
  }
  return joints;
}

double HipHeight(const Robot& robot, const std::vector<double>& joints) {
  return -(LinkPoses(robot, joints)[robot.legs[0].foot_link] * robot.legs[0].sole_center).z();
}

/// A robot that stands with bent knees, `lift` above the floor.
World Standing(const PhysicsOptions& physics = {}, uint64_t seed = 1, double lift = 0, const Scene& scene = {}) {
  const Robot robot = Shipped();
  World world(robot, scene, physics, {}, seed);
  world.SetState(Pose(Eigen::Quaterniond::Identity(), {0, 0, HipHeight(robot, Crouch(robot)) + lift}), Crouch(robot));
  return world;
}

void Simulate(World& world, double seconds) {
  const int64_t end = world.stamp_ns() + std::llround(seconds * 1e9);
  while (world.stamp_ns() < end) world.Step();
}

TEST(World, LinksLieAndWeighAsTheRobotSays) {
  for (const std::string& name : ListRobots(kModels)) {
    const Robot robot = Shipped(name);
    World world(robot, Scene(), PhysicsOptions(), {}, 1);
    RandomStream random(3, name);
    std::vector<double> joints(robot.joints.size(), 0.0);
    for (size_t i = 0; i < joints.size(); ++i) {
      if (robot.joints[i].kind != RobotJoint::Kind::kFixed)
        joints[i] = random.Uniform(robot.joints[i].lower, robot.joints[i].upper);
    }
    const Pose X_WB(RotZ(0.3), {0.1, -0.2, robot.kind == Robot::Kind::kOmniBase ? robot.base_height_m : 1.0});
    world.SetState(X_WB, joints);
    const std::vector<Pose> poses = LinkPoses(robot, joints);
    for (size_t i = 0; i < robot.links.size(); ++i) {
      const int body = mj_name2id(world.model(), mjOBJ_BODY, robot.links[i].name.c_str());
      ASSERT_GE(body, 0);
      const Pose X_WL = X_WB * poses[i];
      // Two ways to multiply the same rotations; they differ by rounding only.
      EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(world.data()->xpos + 3 * body) - X_WL.translation).norm(), 1e-12);
      const double* q = world.data()->xquat + 4 * body;
      EXPECT_LT(RotationAngle(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), X_WL.rotation), 1e-12);
      EXPECT_EQ(world.model()->body_mass[body], robot.links[i].mass_kg);
    }
    EXPECT_LT((world.X_WB().translation - X_WB.translation).norm(), 1e-15);
    EXPECT_EQ(world.JointPositions(), joints);
  }
}

TEST(World, FeetCarryTheWeight) {
  World world = Standing();
  Simulate(world, 1.0);
  EXPECT_FALSE(world.HasFallen());
  // Settled: what is left of the first impact is below a thousandth of the weight.
  EXPECT_NEAR(world.FootForce(0) + world.FootForce(1), 9.81 * world.robot().TotalMass(), 0.02);
  EXPECT_TRUE(world.FootContact(0) && world.FootContact(1));
  EXPECT_EQ(world.stamp_ns(), 1000000000);
}

TEST(World, AMasslessRootIsCarriedByWhatIsFixedToIt) {
  // As many ROS models have it: `base_footprint` without mass, the trunk fixed above it.
  Robot robot = Shipped();
  for (RobotJoint& joint : robot.joints) ++joint.parent_link, ++joint.child_link;
  RobotJoint fixed;
  fixed.name = "to_trunk";
  fixed.parent_link = 0;
  fixed.child_link = 1;
  fixed.X_PJ.translation.z() = 0.2;
  robot.joints.insert(robot.joints.begin(), fixed);
  robot.servos.insert(robot.servos.begin(), ServoOptions());
  robot.links.insert(robot.links.begin(), RobotLink());
  robot.links[0].name = "base_footprint";
  for (RobotLeg& leg : robot.legs) {
    ++leg.foot_link;
    for (int& joint : leg.joints) ++joint;
  }
  ++robot.camera.link, ++robot.imu.link, ++robot.neck_pan, ++robot.neck_tilt;
  World world(robot, Scene(), PhysicsOptions(), {}, 1);
  world.SetState(Pose(Eigen::Quaterniond::Identity(), {0, 0, HipHeight(robot, Crouch(robot))}), Crouch(robot));
  Simulate(world, 1.0);
  EXPECT_NEAR(world.FootForce(0) + world.FootForce(1), 9.81 * robot.TotalMass(), 0.02);
}

TEST(World, FeetDoNotTouchInTheAir) {
  World world = Standing({}, 1, 0.05);
  Simulate(world, 0.05);  // falls 12 mm
  EXPECT_FALSE(world.FootContact(0) || world.FootContact(1));
  EXPECT_NEAR(world.X_WB().translation.z(),
              HipHeight(world.robot(), Crouch(world.robot())) + 0.05 - 0.5 * 9.81 * 0.05 * 0.05, 1e-3);
}

TEST(World, FallIsNoticed) {
  World world = Standing();
  const Robot& robot = world.robot();
  Eigen::Matrix3d tilt = RotX(0.8);
  world.SetState(Pose(tilt, {0, 0, HipHeight(robot, Crouch(robot)) + 0.03}), Crouch(robot));
  EXPECT_FALSE(world.HasFallen());
  Simulate(world, 1.5);
  EXPECT_TRUE(world.HasFallen()) << world.X_WB().R()(2, 2) << " " << world.X_WB().translation.z();
}

TEST(World, RobotStandsOnBoxesAndTexturesChangeNothing) {
  Scene scene;
  SceneBox box;
  box.X_WB = Pose(RotZ(0.2), {0, 0, 0.05});
  box.size = {0.6, 0.6, 0.1};
  scene.boxes.push_back(box);
  World plain = Standing({}, 1, 0.1, scene);
  Simulate(plain, 0.5);
  EXPECT_NEAR(plain.X_WB().translation.z(), HipHeight(plain.robot(), Crouch(plain.robot())) + 0.1, 1e-3);
  scene.textures.push_back(TextureOf("checker", cv::Mat(16, 16, CV_8UC3, cv::Scalar(10, 200, 30))));
  scene.boxes[0].texture = scene.floor_texture = 0;
  scene.lights.emplace_back();
  World textured = Standing({}, 1, 0.1, scene);
  Simulate(textured, 0.5);
  EXPECT_EQ(textured.record().last_stamp_ns(), plain.record().last_stamp_ns());
  EXPECT_TRUE(std::equal(plain.data()->qpos, plain.data()->qpos + plain.model()->nq, textured.data()->qpos));
  scene.boxes[0].collides = false;
  World sunk = Standing({}, 1, 0, scene);
  Simulate(sunk, 0.2);
  EXPECT_NEAR(sunk.X_WB().translation.z(), HipHeight(sunk.robot(), Crouch(sunk.robot())), 1e-3);
}

TEST(World, RunsAreRepeatedToTheBit) {
  PhysicsOptions physics;
  physics.mass_noise_ratio = 0.1;
  physics.friction_noise_ratio = 0.1;
  World a = Standing(physics, 5, 0.02), b = Standing(physics, 5, 0.02), c = Standing(physics, 6, 0.02);
  Simulate(a, 0.3), Simulate(b, 0.3), Simulate(c, 0.3);
  const int n = a.model()->nq;
  EXPECT_TRUE(std::equal(a.data()->qpos, a.data()->qpos + n, b.data()->qpos));
  EXPECT_FALSE(std::equal(a.data()->qpos, a.data()->qpos + n, c.data()->qpos));
}

TEST(World, NoiseChangesTheSimulatedRobotWithinItsBoundsAndNotTheNominalOne) {
  PhysicsOptions physics;
  physics.mass_noise_ratio = 0.1;
  physics.friction_noise_ratio = 0.2;
  const World world = Standing(physics, 7);
  bool changed = false;
  for (const RobotLink& link : world.robot().links) {
    const int body = mj_name2id(world.model(), mjOBJ_BODY, link.name.c_str());
    EXPECT_EQ(world.nominal_model()->body_mass[body], link.mass_kg);
    const double factor = link.mass_kg > 0 ? world.model()->body_mass[body] / link.mass_kg : 1;
    EXPECT_LE(std::abs(factor - 1), 0.1);
    if (std::abs(factor - 1) > 0.01) changed = true;
    if (link.mass_kg == 0) continue;
    EXPECT_NEAR(world.model()->body_inertia[3 * body] / world.nominal_model()->body_inertia[3 * body], factor, 1e-12);
  }
  EXPECT_TRUE(changed);
  // MuJoCo's derived constants were brought up to date, and the scene's scale (which scales clipping planes) was not.
  double mass = 0;
  for (int body = 1; body < world.model()->nbody; ++body) mass += world.model()->body_mass[body];
  EXPECT_NEAR(world.model()->body_subtreemass[mj_name2id(world.model(), mjOBJ_BODY, "trunk")], mass, 1e-12);
  EXPECT_EQ(world.model()->stat.extent, world.nominal_model()->stat.extent);
  const int floor = mj_name2id(world.model(), mjOBJ_GEOM, "floor");
  EXPECT_EQ(world.nominal_model()->geom_friction[3 * floor], 0.8);
  EXPECT_NE(world.model()->geom_friction[3 * floor], 0.8);
  EXPECT_NEAR(world.model()->geom_friction[3 * floor], 0.8, 0.16);
}

TEST(World, FloorDecidesFriction) {
  Scene scene;
  scene.floor_friction = 0.1;
  World world = Standing({}, 1, 0, scene);
  Simulate(world, 0.1);
  ASSERT_GT(world.data()->ncon, 0);
  EXPECT_EQ(world.data()->contact[0].friction[0], 0.1);
}

TEST(World, ServosAreScaledByClass) {
  World world = Standing();
  world.ScaleServos(0.5, 2);
  world.ScaleServos(0.5, 2);  // relative to the robot file, not to the last call
  const auto gain = [&](const std::string& joint) {
    return world.model()
        ->actuator_gainprm[mjNGAIN * mj_name2id(world.model(), mjOBJ_ACTUATOR, ("servo_" + joint).c_str())];
  };
  const auto damping = [&](const std::string& joint) {
    return world.model()
        ->actuator_biasprm[mjNBIAS * mj_name2id(world.model(), mjOBJ_ACTUATOR, ("servo_" + joint).c_str()) + 2];
  };
  EXPECT_EQ(gain("l_knee"), 12.5);
  EXPECT_EQ(damping("l_knee"), -0.125);
  EXPECT_EQ(gain("neck_pan"), 6);
  EXPECT_EQ(gain("l_elbow"), 25);
}

TEST(World, CamerasSitOnTheMountAndLookAlongTheirOpticalAxis) {
  const Robot robot = Shipped();
  const Pose X_MR(RotY(0.1), {0.06, 0, 0});
  World world(robot, Scene(), PhysicsOptions(), {{"left", Pose()}, {"right", X_MR}}, 1);
  const std::vector<double> joints = Crouch(robot);
  const Pose X_WB(RotZ(0.7), {1, 2, 0.15});
  world.SetState(X_WB, joints);
  const Pose X_WM = X_WB * LinkPoses(robot, joints)[robot.camera.link] * robot.camera.X_LS;
  const int right = mj_name2id(world.model(), mjOBJ_CAMERA, "right");
  const Pose X_WR = X_WM * X_MR;
  EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(world.data()->cam_xpos + 3 * right) - X_WR.translation).norm(), 1e-12);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> view(world.data()->cam_xmat + 9 * right);
  EXPECT_LT((view.col(0) - X_WR.R().col(0)).norm(), 1e-12);
  EXPECT_LT((view.col(1) + X_WR.R().col(1)).norm(), 1e-12) << "MuJoCo's y is up";
  EXPECT_LT((view.col(2) + X_WR.R().col(2)).norm(), 1e-12) << "MuJoCo looks along -z";
}

TEST(World, BadStateIsNeverSilent) {
  World world = Standing();
  world.data()->qvel[0] = 1e12;
  try {
    Simulate(world, 0.01);
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), testing::AllOf(testing::HasSubstr("MuJoCo at "), testing::HasSubstr("unstable")));
  }
  EXPECT_THROW(world.SetTargets(std::vector<double>(world.target_count(), std::nan(""))), std::logic_error);
}

TEST(World, ControlPeriodIsAWholeMultipleOfTheStep) {
  PhysicsOptions physics;
  physics.control_period_ms = 5;
  try {
    Standing(physics);
    FAIL();
  } catch (const BadOption& e) {
    EXPECT_STREQ(e.what(), "physics.control_period_ms = 5: expected a whole multiple of physics.timestep_ms = 2");
  }
}

TEST(World, MeshesReachMujocoAndBrokenOnesAreNamed) {
  const TemporaryFolder folder;
  const std::filesystem::path file =
      folder.Write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  Robot robot = Shipped();
  RobotShape shape;
  shape.kind = RobotShape::Kind::kMesh;
  shape.size = {0.05, 0.05, 0.05};
  shape.mesh = file;
  robot.links[0].visuals = {shape, shape};
  const World world(robot, Scene(), PhysicsOptions(), {}, 1);
  EXPECT_EQ(world.model()->nmesh, 1);
  folder.Write("mesh.obj", "no mesh");
  EXPECT_THROW(World(robot, Scene(), PhysicsOptions(), {}, 1), BadInput);
  std::filesystem::remove(file);
  EXPECT_THROW(World(robot, Scene(), PhysicsOptions(), {}, 1), BadInput);
}

TEST(World, MoreTexturesThanMujocoDrawsAreRefused) {
  Scene scene;
  for (int i = 0; i < 100; ++i) {
    scene.textures.push_back(TextureOf("t", cv::Mat(4, 4, CV_8UC3, cv::Scalar(i, 0, 0))));
    SceneBox box;
    box.size = {0.1, 0.1, 0.1};
    box.texture = i;
    scene.boxes.push_back(box);
  }
  EXPECT_THROW(BuildMjcf(Shipped(), scene, PhysicsOptions(), {}), BadInput);
}

/// In the air with all joints on their way to new targets: everything moves, nothing touches.
World Tumbling(double timestep_ms) {
  PhysicsOptions physics;
  physics.timestep_ms = timestep_ms;
  physics.control_period_ms = 4;
  World world = Standing(physics, 1, 1.0);
  for (int i = 0; i < 6; ++i) world.data()->qvel[i] = 0.5 + 0.3 * i;
  mj_forward(world.model(), world.data());
  std::vector<double> targets(world.target_count(), 0.0);
  world.SetTargets(targets);
  return world;
}

/// Positions of a world's record at any instant within it.
class Positions {
 public:
  explicit Positions(const World& world) : world_(world), scratch_(mj_makeData(world.model())) {}
  Eigen::VectorXd At(int64_t stamp_ns) const {
    world_.record().Evaluate(world_.model(), stamp_ns, scratch_.get());
    return Eigen::Map<const Eigen::VectorXd>(scratch_->qpos, world_.model()->nq);
  }

 private:
  const World& world_;
  MjDataPtr scratch_;
};

TEST(MotionRecord, EqualsTheSimulationAtItsSteps) {
  World world = Tumbling(2);
  MjDataPtr scratch(mj_makeData(world.model()));
  for (int i = 0; i < 30; ++i) {
    world.Step();
    world.record().Evaluate(world.model(), world.stamp_ns(), scratch.get());
    for (int k = 0; k < world.model()->nq; ++k) EXPECT_NEAR(scratch->qpos[k], world.data()->qpos[k], 1e-12);
    // Kinematics too, as a step leaves the data up to date.
    for (int k = 0; k < 3 * world.model()->nbody; ++k) EXPECT_NEAR(scratch->xpos[k], world.data()->xpos[k], 1e-12);
  }
}

TEST(MotionRecord, IsContinuousAndReachesEachStepFromTheOneBefore) {
  World world = Tumbling(2);
  for (int i = 0; i < 20; ++i) world.Step();
  const Positions positions(world);
  for (int64_t step = 1; step <= 20; ++step) {
    const int64_t stamp = step * 2000000;
    // Velocities are below 20 rad/s, so that 1 ns moves nothing by more than 2e-8.
    EXPECT_LT((positions.At(stamp) - positions.At(stamp - 1)).norm(), 1e-7);
  }
}

TEST(MotionRecord, AgreesWithATwentyTimesFinerSimulation) {
  World coarse = Tumbling(2), fine = Tumbling(0.1);
  Simulate(coarse, 0.06), Simulate(fine, 0.06);
  const Positions of_coarse(coarse), of_fine(fine);
  double worst_translation = 0, worst_joint = 0;
  for (int64_t stamp = 0; stamp <= 60000000; stamp += 700000) {
    const Eigen::VectorXd d = of_coarse.At(stamp) - of_fine.At(stamp);
    worst_translation = std::max(worst_translation, d.head<3>().norm());
    worst_joint = std::max(worst_joint, d.tail(d.size() - 7).cwiseAbs().maxCoeff());
  }
  // Semi-implicit Euler is of first order: free fall over t is off by g t dt / 2 = 0.6 mm after 60 ms; joints that
  // reach 10 rad/s within a few steps are off by about half a step of that speed, 10 mrad.
  EXPECT_LT(worst_translation, 1.0e-3);
  EXPECT_LT(worst_joint, 0.03);
}

TEST(MotionRecord, ForgetsWhatIsNotAskedFor) {
  World world = Tumbling(2);
  for (int i = 0; i < 20; ++i) world.Step();
  const Positions positions(world);
  const Eigen::VectorXd before = positions.At(21000000);
  world.record().DropBefore(21000000);
  EXPECT_EQ(world.record().first_stamp_ns(), 20000000);
  EXPECT_EQ(positions.At(21000000), before);
  EXPECT_THROW(positions.At(19000000), std::logic_error);
  EXPECT_THROW(positions.At(40000001), std::logic_error);
}

}  // namespace
}  // namespace gaitcam
