// A robot that stops when asked, looks all around and goes on: in physics, with servos, sensors and a camera.

#include "sim/walking/head_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "sim/simulation.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

/// A small picture often enough: 25 Hz as the real robots had, one instant per image.
SimulationOptions Options(const Robot& robot, const std::string& preset = "normal") {
  SimulationOptions options;
  options.gait = robot.kind == Robot::Kind::kHumanoid ? robot.gaits.at(preset) : GaitOptions();
  options.path.length_m = 1.2;
  options.camera.width_px = 40;
  options.camera.height_px = 30;
  options.camera.hfov_deg = 56.9;
  options.camera.rate_hz = 25;
  options.camera.pitch_deg = 0;
  options.camera.antialias = 1;
  options.camera.exposure.exposure_ms = 5;
  options.camera.exposure.fixed_subframes = 1;
  return options;
}

/// What frames with a scan state say, and what was true of them.
struct ScanLog {
  std::vector<double> pan_error_deg;  ///< Of pan and body's turn together, against the camera's true yaw.
  std::set<int> seen_deg;             ///< Directions that some column of some frame looked in, from the scan's begin.
  std::vector<double> blur_px;
  double begin_s = 0, end_s = 0;
  double way_m = 0;  ///< Of the root while it swept.
  double body_turn_rad = 0;
};

struct Walked {
  std::vector<ScanLog> scans;
  std::vector<double> path_error_m;  ///< Of the root, per frame.
  std::vector<double> stop_s;        ///< From being asked to walking again.
  SimulationStatus status = SimulationStatus::kWalking;
  PlanarPose end;
  Eigen::Quaterniond last_rotation;
  int64_t expected_frames = 0, frames = 0;
};

void AddFrame(const SimulatedFrame& frame, double half_view_rad, double yaw_begin, ScanLog& log) {
  const ScanState& scan = *frame.observation.scan;
  const Eigen::Vector3d view = frame.truth.X_WC.R().col(2);
  const double yaw = std::remainder(std::atan2(view.y(), view.x()) - yaw_begin, 2 * pi);
  const double said = scan.pan_rad + scan.body_turn_rad;
  log.pan_error_deg.push_back(std::abs(std::remainder(said - yaw, 2 * pi)) / kRadPerDeg);
  log.blur_px.push_back(frame.truth.blur_median_px);
  for (double a = -half_view_rad; a <= half_view_rad; a += 0.25 * kRadPerDeg) {
    log.seen_deg.insert((int(std::floor((yaw + a) / kRadPerDeg)) + 720) % 360);
  }
  log.body_turn_rad = scan.body_turn_rad;
  log.end_s = SecondsIntoWalk(frame.truth.stamp_ns);
  if (log.begin_s == 0) log.begin_s = log.end_s;
}

/// Walks to the end; at each of these frames a scan is asked for.
Walked Walk(const Robot& robot, const SimulationOptions& options, const std::set<int64_t>& ask_at, uint64_t seed = 1) {
  Scene scene;
  scene.floor_min = {-20, -20};
  scene.floor_max = {20, 20};
  Simulation simulation(robot, scene, options, seed);
  const double half_view = options.camera.hfov_deg / 2 * kRadPerDeg;
  const Path path(options.path, {});
  Walked walked;
  double yaw_begin = 0, asked_s = 0;
  bool scanned = false;
  while (const auto frame = simulation.Next({false, false, true})) {
    const double time_s = SecondsIntoWalk(frame->truth.stamp_ns);
    const Pose& X_WB = *frame->truth.X_WB;
    if (frame->observation.scan && !scanned) {
      walked.scans.emplace_back();
      yaw_begin = X_WB.Yaw();
    }
    if (frame->observation.scan) AddFrame(*frame, half_view, yaw_begin, walked.scans.back());
    scanned = simulation.scans() && (scanned || frame->observation.scan);
    if (asked_s > 0 && !simulation.scans()) {
      walked.stop_s.push_back(time_s - asked_s);
      asked_s = 0;
    }
    if (ask_at.count(walked.frames++)) {
      simulation.RequestScan();
      asked_s = time_s;
    }
    walked.path_error_m.push_back(path.DistanceTo(X_WB.translation.head<2>()));
    walked.end = PlanarPose(X_WB);
    walked.last_rotation = X_WB.rotation;
  }
  walked.status = simulation.status();
  walked.expected_frames = simulation.ExpectedFrames();
  return walked;
}

/// The robot saw the whole circle sharply, and knew where it looked.
void ExpectGoodScan(const ScanLog& scan) {
  EXPECT_EQ(scan.seen_deg.size(), 360U);
  // Half a degree is an encoder's reading, the sway of the body and the servos' lag together; the trunk leans a little.
  EXPECT_LT(Worst(scan.pan_error_deg), 0.5);
  EXPECT_LT(Worst(scan.blur_px), 0.5);  // 0.8 rad/s at f = 37 px for 5 ms: 0.15 px
}

TEST(HeadScan, WalkerStopsTwiceSeesAllAroundAndEndsOnItsPath) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  const Walked walked = Walk(robot, Options(robot), {60, 500});
  EXPECT_EQ(walked.status, SimulationStatus::kFinished);
  ASSERT_EQ(walked.scans.size(), 2U);
  for (const ScanLog& scan : walked.scans) {
    ExpectGoodScan(scan);
    EXPECT_NEAR(scan.body_turn_rad, 0, 0.002);                            // the gyroscope's drift while it settled
    EXPECT_NEAR(scan.end_s - scan.begin_s, 320 * kRadPerDeg / 0.8, 0.4);  // ramps and the frames' raster
  }
  EXPECT_NEAR(walked.end.position.x(), 1.2, 0.06);
  EXPECT_LT(Worst(walked.path_error_m), 0.06);  // the sway from side to side, as without a stop
  EXPECT_NEAR(double(walked.expected_frames), double(walked.frames), 0.1 * double(walked.frames));
}

TEST(HeadScan, TheSameSeedGivesTheSameBits) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  SimulationOptions options = Options(robot);
  options.path.length_m = 0.4;
  const Walked one = Walk(robot, options, {20}), two = Walk(robot, options, {20});
  EXPECT_EQ(one.last_rotation.coeffs(), two.last_rotation.coeffs());
  EXPECT_EQ(one.scans.at(0).pan_error_deg, two.scans.at(0).pan_error_deg);
}

TEST(HeadScan, AHeadThatReachesLessFarNeedsTheBodyToTurn) {
  const Robot robot = ReadShippedRobot("khr1hv");
  const Walked walked = Walk(robot, Options(robot), {60});
  EXPECT_EQ(walked.status, SimulationStatus::kFinished);
  ASSERT_EQ(walked.scans.size(), 1U);
  ExpectGoodScan(walked.scans[0]);
  EXPECT_NEAR(std::abs(walked.scans[0].body_turn_rad), pi, 0.05);
  EXPECT_NEAR(walked.end.position.x(), 1.2, 0.06);
  EXPECT_NEAR(walked.end.heading, 0, 0.05);
  EXPECT_LT(Worst(walked.path_error_m), 0.06);
}

TEST(HeadScan, MayComeBeforeTheFirstStepAndAfterTheLast) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  SimulationOptions options = Options(robot);
  options.path.length_m = 0.2;
  const Walked without = Walk(robot, options, {});
  const Walked walked = Walk(robot, options, {0, 12 * 25 + without.frames - 20});
  EXPECT_EQ(walked.status, SimulationStatus::kFinished);
  ASSERT_EQ(walked.scans.size(), 2U);
  EXPECT_LT(walked.scans[0].begin_s, 3.5);  // it has not walked: settled, the head turned
  for (const ScanLog& scan : walked.scans) ExpectGoodScan(scan);
  EXPECT_LT((walked.end.position - without.end.position).norm(), 0.02);
}

TEST(HeadScan, StandingRobotAndWheeledBaseScanToo) {
  const Robot robot = ReadShippedRobot("khr1hv_pan"), base = ReadShippedRobot("omni_base");
  SimulationOptions options = Options(robot);
  options.path.kind = PathKind::kStand;
  options.path.duration_s = 0.5;
  const Walked stood = Walk(robot, options, {10});
  EXPECT_EQ(stood.status, SimulationStatus::kFinished);
  ExpectGoodScan(stood.scans.at(0));
  const Walked driven = Walk(base, Options(base), {60});
  ExpectGoodScan(driven.scans.at(0));
  EXPECT_NEAR(driven.end.position.x(), 1.2, 1e-3);
}

TEST(HeadScan, AFallDuringTheStopIsAFall) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  SimulationOptions options = Options(robot);
  options.path.kind = PathKind::kStand;
  options.path.settle_s = 0.2;
  Robot weak = robot;
  for (const RobotLeg& leg : weak.legs) {
    for (const int joint : leg.joints) weak.servos[size_t(joint)].torque_limit = 0.02;  // gives way under the weight
  }
  EXPECT_EQ(Walk(weak, options, {0}).status, SimulationStatus::kFell);
}

TEST(HeadScan, ALongExposureMakesTheSweepSlower) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  const CameraModel camera = CameraModel::FromHorizontalFov(208, 160, 56.9);
  EXPECT_EQ(PlanHeadScan(robot, {}, camera, 5e-3).speed_rad_s, 0.8);
  EXPECT_NEAR(PlanHeadScan(robot, {}, camera, 20e-3).speed_rad_s, 1.3 / (192 * 20e-3), 2e-3);
}

TEST(HeadScan, AHeadThatCannotReachIsRefusedWithItsReach) {
  Robot robot = ReadShippedRobot("khr1hv");
  RobotJoint& pan = robot.joints[size_t(robot.neck_pan)];
  pan.lower = -0.9;
  const CameraModel camera = CameraModel::FromHorizontalFov(208, 160, 56.9);
  try {
    PlanHeadScan(robot, {}, camera, 0);
    FAIL() << "a head that reaches 52 degrees was accepted";
  } catch (const BadOption& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("scan: khr1hv cannot look all around: its head pans by 52 degrees to each side; "
                          "expected at least 62 with this camera"));
  }
}

TEST(HeadPan, SharesTheWayBetweenItsJoints) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  const HeadPan pan(robot);
  EXPECT_NEAR(pan.reach_rad() / kRadPerDeg, 160, 1e-6);
  std::vector<double> joints(robot.joints.size(), 0.0);
  pan.Set(160 * kRadPerDeg, joints);
  EXPECT_NEAR(joints[size_t(robot.neck_pan)] / kRadPerDeg, 100, 1e-6);
  EXPECT_NEAR(joints[size_t(robot.camera_pan)] / kRadPerDeg, 60, 1e-6);
  EXPECT_NEAR(pan.Of(joints) / kRadPerDeg, 160, 1e-6);
  // The camera itself looks there, and as far down as before.
  const Pose X_RC = LinkPoses(robot, joints)[size_t(robot.camera.link)] * robot.camera.X_LS;
  const Eigen::Vector3d view = X_RC.R().col(2);
  EXPECT_NEAR(std::atan2(view.y(), view.x()) / kRadPerDeg, 160, 1e-6);
  EXPECT_NEAR(view.z(), 0, 1e-9);
}

}  // namespace
}  // namespace gaitcam
