#include "sim/walking/omni_drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "sim/world/world.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

Robot Base() { return ReadRobot("omni_base", TestData() / "models"); }

TEST(SmoothProfile, GoesFromRestToRestWithinItsLimits) {
  for (double distance : {0.001, 0.05, 0.3, 2.0}) {
    const SmoothProfile profile(distance, 0.4, 0.5);
    EXPECT_EQ(profile.Position(0), 0);
    EXPECT_NEAR(profile.Position(profile.duration_s() - 1e-9), distance, 1e-9);
    EXPECT_EQ(profile.Position(profile.duration_s() + 1), distance);
    EXPECT_EQ(profile.Speed(0), 0);
    const double dt = 1e-4 * profile.duration_s();
    for (double t = dt; t < profile.duration_s() - dt; t += dt) {
      // Central differences of a smooth function: of second order in dt, and rounding over dt.
      EXPECT_NEAR((profile.Position(t + dt) - profile.Position(t - dt)) / (2 * dt), profile.Speed(t), 1e-6);
      EXPECT_LE(profile.Speed(t), 0.4 + 1e-12);
      EXPECT_LE(std::abs(profile.Speed(t + dt) - profile.Speed(t)) / dt, 0.5 + 1e-6);
    }
  }
  EXPECT_EQ(SmoothProfile(0, 1, 1).duration_s(), 0);
}

struct Drive {
  double worst_m = 0, worst_pitch = 0, end_error_m = 0, end_heading_error = 0, seconds = 0, pan = 0;
};

Drive Follow(const PathOptions& path_options, const OmniDriveOptions& options) {
  const Robot robot = Base();
  const Pose start(RotZ(0.5), {1, 2, 0});
  const Path path(path_options, start);
  World world(robot, Scene(), PhysicsOptions(), {}, 1);
  const auto drive = MakeOmniDrive(robot, options, path_options, start);
  world.SetState(drive->InitialRoot(), drive->InitialJoints());
  Drive result;
  ControlInput input;
  while (!drive->Finished()) {
    input.stamp_ns = world.stamp_ns();
    world.SetTargets(drive->Update(input));
    for (int i = 0; i < 2; ++i) world.Step();
    world.record().DropBefore(world.stamp_ns());
    const Pose X_WB = world.X_WB();
    result.worst_m = std::max(result.worst_m, path.DistanceTo(X_WB.translation.head<2>()));
    result.worst_pitch = std::max(result.worst_pitch, std::acos(std::min(1.0, X_WB.R()(2, 2))));
    result.pan = std::max(result.pan, world.JointPositions()[robot.neck_pan]);
  }
  result.end_error_m = (world.X_WB().translation.head<2>() - path.goal().position).norm();
  result.end_heading_error = std::abs(WrapAngle(world.X_WB().Yaw() - path.goal().heading));
  result.seconds = 1e-9 * double(world.stamp_ns());
  return result;
}

TEST(OmniDrive, FollowsAllPathsClosely) {
  OmniDriveOptions options;
  options.speed_mps = 0.5;
  for (const PathKind kind : {PathKind::kStraight, PathKind::kCircle, PathKind::kSquare, PathKind::kThereAndBack}) {
    PathOptions path;
    path.kind = kind;
    path.length_m = path.side_m = 0.8;
    path.diameter_m = 1;
    const Drive drive = Follow(path, options);
    // The servo of 5 Hz cuts curves by about v^2 / (r w^2) = 0.5 mm and lags where the acceleration changes.
    EXPECT_LT(drive.worst_m, 2e-3) << ToWord(kind);
    EXPECT_LT(drive.end_error_m, 1e-3) << ToWord(kind);
    EXPECT_LT(drive.end_heading_error, 1e-3) << ToWord(kind);
    EXPECT_NEAR(drive.seconds, EstimateDrivingTime(options, path), 0.01) << ToWord(kind);
    EXPECT_LT(drive.worst_pitch, 2e-3) << ToWord(kind) << ": rocks only when it speeds up";
  }
}

TEST(OmniDrive, VibratesWhileDriving) {
  PathOptions path;
  path.length_m = 1;
  OmniDriveOptions options;
  options.speed_mps = 0.5;
  options.vibration_amplitude_rad = 0.004;
  const double pitch = Follow(path, options).worst_pitch;
  // Pitch and roll together, raised towards the rocking frequency: (8 / 15)^2 = 0.28 gives 1.4 times.
  EXPECT_GT(pitch, 0.004);
  EXPECT_LT(pitch, 0.004 * std::sqrt(2.0) * 1.6);
}

TEST(OmniDrive, StandsAndPansItsHead) {
  PathOptions path;
  path.kind = PathKind::kStand;
  path.duration_s = 4;
  const Drive drive = Follow(path, OmniDriveOptions());
  EXPECT_LT(drive.worst_m, 1e-4);
  EXPECT_NEAR(drive.pan, path.pan_amplitude_rad, 0.05);  // the neck's servo trails a little
  EXPECT_NEAR(drive.seconds, 6, 0.01);
}

TEST(OmniDrive, BadOptionsAreRefused) {
  OmniDriveOptions options;
  options.speed_mps = -1;
  EXPECT_THROW(MakeOmniDrive(Base(), options, PathOptions(), Pose()), BadOption);
}

}  // namespace
}  // namespace gaitcam
