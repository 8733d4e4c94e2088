#include "sim/standing_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "algorithms/core/errors.h"
#include "tests/data_folder.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

SimulationOptions StandingOptions(const Robot& robot) {
  SimulationOptions options;
  options.gait = robot.gaits.at("normal");
  options.camera.width_px = 52;
  options.camera.height_px = 40;
  options.camera.hfov_deg = 56.9;
  options.camera.rate_hz = 5;
  options.camera.antialias = 1;
  options.camera.exposure.exposure_ms = 5;
  options.camera.exposure.fixed_subframes = 1;
  return options;
}

bool SamePixels(const SimulatedFrame& a, const SimulatedFrame& b) {
  return cv::norm(a.observation.image.pixels, b.observation.image.pixels, cv::NORM_INF) == 0;
}

class StandingRobotTest : public testing::Test {
 protected:
  StandingRobotTest()
      : robot_(ReadShippedRobot("khr1hv_pan")),
        scene_(ReadScene("plain", TestData() / "models")),
        options_(StandingOptions(robot_)) {}

  Robot robot_;
  Scene scene_;
  SimulationOptions options_;
};

TEST_F(StandingRobotTest, SeesFromWhereItWasPut) {
  StandingRobot standing(robot_, scene_, options_, 1);
  for (const Eigen::Vector3d& pose : {Eigen::Vector3d(0.5, -0.3, 30), Eigen::Vector3d(-0.4, 0.2, -120)}) {
    const SimulatedFrame frame = standing.View(pose, 7);
    EXPECT_LT((frame.truth.X_WB->translation.head<2>() - pose.head<2>()).norm(), 0.02);
    EXPECT_NEAR(frame.truth.X_WB->Yaw() * 180 / std::numbers::pi, pose.z(), 1);
    EXPECT_FALSE(frame.observation.scan.has_value());
  }
}

TEST_F(StandingRobotTest, AScanIsOfItsPoseAndSeedAloneWhateverCameBefore) {
  StandingRobot one(robot_, scene_, options_, 1), two(robot_, scene_, options_, 1);
  const Eigen::Vector3d here(0.2, 0.1, 10);
  two.View({-1, 0.5, 77}, 3);
  const std::vector<SimulatedFrame> a = one.Scan(here, 5), b = two.Scan(here, 5);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 30U);  // 7 s of sweep at 5 Hz
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(SamePixels(a[i], b[i]));
    EXPECT_EQ(a[i].observation.scan->pan_rad, b[i].observation.scan->pan_rad);
  }
  EXPECT_FALSE(SamePixels(a[0], two.Scan(here, 6)[0])) << "another seed is other noise";
}

TEST_F(StandingRobotTest, FramesOfAScanAreThoseThatAWholeSimulationFilms) {
  const Eigen::Vector3d here(0.2, 0.1, 10);
  const std::vector<SimulatedFrame> scan = StandingRobot(robot_, scene_, options_, 1).Scan(here, 1);
  options_.path.kind = PathKind::kStand;
  options_.path.pan_amplitude_rad = 0;
  options_.start = here;
  Simulation simulation(robot_, scene_, options_, 1);
  simulation.RequestScan();
  size_t found = 0;
  while (const auto frame = simulation.Next()) {
    if (!frame->observation.scan) continue;
    ASSERT_LT(found, scan.size());
    EXPECT_EQ(frame->observation.stamp_ns, scan[found].observation.stamp_ns);
    EXPECT_TRUE(SamePixels(*frame, scan[found++]));
  }
  EXPECT_EQ(found, scan.size());
}

TEST_F(StandingRobotTest, ARobotThatCannotLookAllAroundIsRefused) {
  options_.camera.hfov_deg = 20;
  Robot stiff = ReadShippedRobot("khr1hv");
  stiff.neck_pan = -1;
  EXPECT_THROW(StandingRobot(stiff, scene_, options_, 1), BadOption);
}

}  // namespace
}  // namespace gaitcam
