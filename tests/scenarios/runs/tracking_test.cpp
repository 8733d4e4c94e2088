// Systems that act on the body: their walk waits for their answer, and the robot does what they ask.

#include "scenarios/code/runs/tracking.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scenarios/code/files/folders.h"
#include "scenarios/code/runs/handicap.h"

namespace gaitcam {
namespace {

struct Seen {
  std::vector<int64_t> stamps;
  std::vector<double> pans;  ///< Of frames with a scan state.
};

/// Asks for a scan at one of its frames and goes on asking until it has seen the scan begin.
class Scanner : public System {
 public:
  Scanner(Seen& seen, size_t ask_at, bool breaks = false) : seen_(seen), ask_at_(ask_at), breaks_(breaks) {}
  FrameEstimate Track(const Observation& observation) override {
    seen_.stamps.push_back(observation.stamp_ns);
    if (observation.scan) seen_.pans.push_back(observation.scan->pan_rad);
    if (breaks_ && seen_.stamps.size() == 4) throw std::runtime_error("it broke");
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    return answer;
  }
  BodyCommand Command() const override {
    if (seen_.stamps.size() >= ask_at_ && seen_.pans.empty()) return Scan();
    return FollowPath();
  }
  FinalEstimate Finish() override { return {{}, {PlaceGraph()}, "it stopped"}; }

 private:
  Seen& seen_;
  size_t ask_at_;
  bool breaks_;
};

/// Watches a walk and asks for nothing.
class Bystander : public System {
 public:
  FrameEstimate Track(const Observation& observation) override {
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    return answer;
  }
};

SimulationOptions Options(const Robot& robot) {
  SimulationOptions options;
  options.gait = robot.gaits.at("normal");
  options.path.length_m = 0.3;
  options.camera.width_px = 52;
  options.camera.height_px = 40;
  options.camera.rate_hz = 5;
  options.camera.antialias = 1;
  options.camera.exposure.exposure_ms = 5;
  options.camera.exposure.fixed_subframes = 1;
  return options;
}

class LiveTracking : public testing::Test {
 protected:
  LiveTracking()
      : robot_(ReadRobot("khr1hv_pan", ModelsFolder())),
        place_(ReadScene("plain", ModelsFolder())),
        simulation_(robot_, place_, Options(robot_), 1) {}

  Robot robot_;
  Scene place_;
  Simulation simulation_;
};

TEST_F(LiveTracking, TheBodyScansWhenTheSystemAsksAndThenFinishesItsPath) {
  Seen seen;
  TrackingThread tracker(std::make_unique<Scanner>(seen, 8), true);
  size_t shown = 0;
  LiveTrackingOptions options;
  options.on_frame = [&](const SimulatedFrame&) { ++shown; };
  const Estimate estimate = TrackLive(simulation_, tracker, options);
  EXPECT_EQ(simulation_.status(), SimulationStatus::kFinished);
  EXPECT_EQ(seen.stamps.size(), shown);
  EXPECT_EQ(estimate.frames.size(), shown);
  ASSERT_GT(seen.pans.size(), 30U);  // 320 degrees at 0.8 rad/s and 5 Hz, once
  EXPECT_LT(seen.pans.size(), 45U);
  EXPECT_GT(seen.pans.front(), 2.5);
  EXPECT_LT(seen.pans.back(), -2.5);
  EXPECT_TRUE(FindMap<PlaceGraph>(estimate.maps));
  EXPECT_EQ(estimate.failure, "it stopped");
}

TEST_F(LiveTracking, AHandicapLetsTheSystemActAsItWishes) {
  Seen seen;
  HandicapOptions handicap;
  handicap.pose_noise = 0.1;
  TrackingThread tracker(std::make_unique<HandicappedSystem>(std::make_unique<Scanner>(seen, 3), handicap, 1), true);
  ASSERT_TRUE(tracker.acts());
  const Estimate estimate = TrackLive(simulation_, tracker, {});
  EXPECT_GT(seen.pans.size(), 30U);
  EXPECT_TRUE(FindMap<PlaceGraph>(estimate.maps));
  EXPECT_EQ(estimate.failure, "it stopped");
}

TEST_F(LiveTracking, WhatTheSystemThrowsIsThrownAgain) {
  Seen seen;
  TrackingThread tracker(std::make_unique<Scanner>(seen, 100, true), true);
  EXPECT_THROW(TrackLive(simulation_, tracker, {}), std::runtime_error);
  EXPECT_EQ(seen.stamps.size(), 4U);
}

TEST_F(LiveTracking, OthersAreNotWaitedForAndMayBeInterrupted) {
  TrackingThread tracker(std::make_unique<Bystander>());
  EXPECT_FALSE(tracker.acts());
  size_t shown = 0;
  LiveTrackingOptions options;
  options.on_frame = [&](const SimulatedFrame&) { ++shown; };
  options.interrupted = [&] { return shown >= 6; };
  const Estimate estimate = TrackLive(simulation_, tracker, options);
  EXPECT_EQ(estimate.frames.size(), 7U);  // with the frame that was in work
  EXPECT_EQ(estimate.frames.size(), shown);
  EXPECT_TRUE(estimate.maps.empty());
  EXPECT_EQ(simulation_.status(), SimulationStatus::kWalking);
}

}  // namespace
}  // namespace gaitcam
