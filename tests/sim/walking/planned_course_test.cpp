#include "sim/walking/planned_course.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenarios/code/experiments/walk_trial.h"
#include "sim/walking/walker.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

PathOptions Corner() {
  PathOptions path;
  path.kind = PathKind::kPolyline;
  path.points = {{0.8, 0}, {0.8, 0.6}};
  return path;
}

TEST(PlannedCourse, AWheeledBaseDrivesWhereItIsPlanned) {
  const Robot robot = ReadRobot("omni_base", kModels);
  OmniDriveOptions drive;
  drive.speed_mps = 0.5;
  const Pose start(RotZ(0.5), {1, 2, 0});
  const PlannedCourse course = PlanCourse(robot, {}, drive, Corner(), start);
  World world(robot, Scene(), PhysicsOptions(), {}, 1);
  const auto controller = MakeOmniDrive(robot, drive, Corner(), start);
  world.SetState(controller->InitialRoot(), controller->InitialJoints());
  ControlInput input;
  double farthest_m = 0;
  while (!controller->Finished()) {
    input.stamp_ns = world.stamp_ns();
    world.SetTargets(controller->Update(input));
    for (int i = 0; i < 2; ++i) world.Step();
    world.record().DropBefore(world.stamp_ns());
    const PlanarPose planned = course(1e-9 * double(world.stamp_ns()));
    farthest_m = std::max(farthest_m, (world.X_WB().translation.head<2>() - planned.position).norm());
  }
  EXPECT_LT(farthest_m, 0.01);  // the servo's lag where the acceleration changes
  EXPECT_EQ(course(-5).position, start.translation.head<2>());
  EXPECT_LT((course(1000).position - Path(Corner(), start).goal().position).norm(), 1e-9);
}

TEST(PlannedCourse, AHumanoidIsWithinADecimetreOfWhereItIsPlanned) {
  const Robot robot = ReadRobot("khr1hv", kModels);
  const GaitOptions& gait = robot.gaits.at("normal");
  WalkTrialOptions options;
  options.path = Corner();
  const PlannedCourse course = PlanCourse(robot, gait, {}, options.path, Pose());
  const double whole_s = EstimateWalkingTime(gait, options.path);
  for (const double part : {0.3, 0.6, 1.0}) {
    options.longest_s = part * whole_s;
    const WalkTrialResult walk = RunWalkTrial(robot, gait, options);
    ASSERT_FALSE(walk.fell);
    // The body is up to half a step behind the print that lands, sways, and the feet slip.
    EXPECT_LT((walk.end.position - course(walk.end_s).position).norm(), 0.1) << part;
  }
  EXPECT_EQ(course(0).position, Eigen::Vector2d(0, 0));
}

TEST(PlannedCourse, WhoStandsStaysWhereItStarts) {
  PathOptions path;
  path.kind = PathKind::kStand;
  const Pose start(RotZ(0.5), {1, 2, 0});
  for (const char* name : {"omni_base", "khr1hv"}) {
    const Robot robot = ReadRobot(name, kModels);
    const GaitOptions gait = robot.gaits.count("normal") ? robot.gaits.at("normal") : GaitOptions();
    const PlannedCourse course = PlanCourse(robot, gait, {}, path, start);
    for (const double time_s : {0.0, 3.0, 100.0}) {
      EXPECT_LT((course(time_s).position - start.translation.head<2>()).norm(), 1e-9) << name;
    }
  }
}

}  // namespace
}  // namespace gaitcam
