// A robot in synthetic rooms that have nothing in common: it changes rooms from one frame to the next, and scans when
// asked to.

#include "algorithms/slam/topo_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "algorithms/slam/system.h"
#include "tests/algorithms/places/cylinder_world.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
constexpr double kDeg = std::numbers::pi / 180;

Calibration Ers7() {
  Calibration calibration;
  calibration.camera = Ers7Camera();
  calibration.frame_rate_hz = 10;
  calibration.standing = StandingCamera{0.2, UpOf(4)};
  return calibration;
}

bool WantsScan(const System& system) { return std::holds_alternative<gaitcam::Scan>(system.Command()); }

/// Serves a system's commands; everything takes as many frames as it takes.
class WalkOfRooms {
 public:
  explicit WalkOfRooms(System& system, const std::vector<uint64_t>& rooms = {1, 2, 3, 4}) : system_(system) {
    for (const uint64_t seed : rooms) rooms_.emplace_back(seed);
  }

  /// Foot switches: so many steps straight ahead before the next frame.
  void Step(int steps) {
    for (int k = 0; k < steps; ++k) {
      left_ = !left_;
      JointSample sample;
      sample.stamp_ns = stamp_ns_ + 1'000'000 * (k + 1);
      sample.left_contact = left_;
      sample.right_contact = !left_;
      joints_.push_back(sample);
    }
  }

  /// Stands in a room, looking to and fro, for `frames`, not counting scans.
  void Stay(size_t room, int frames, double yaw_deg = 20) {
    for (int k = 0; k < frames; ++k) {
      if (WantsScan(system_)) Scan(room);
      Show(room, (yaw_deg + 3 * std::sin(k)) * kDeg, std::nullopt);
    }
  }
  void Scan(size_t room, double reach_deg = 180) {
    for (double pan = reach_deg; pan > -reach_deg; pan -= 12) Show(room, pan * kDeg, ScanState{pan * kDeg, 0});
  }
  /// Two sweeps of half a circle, and a turn on the spot that is no part of the scan.
  void ScanByTurning(size_t room) {
    for (const double turn : {0.0, 180.0}) {
      for (double pan = 90; pan >= -90; pan -= 10) Show(room, (pan + turn) * kDeg, ScanState{pan * kDeg, turn * kDeg});
      for (int k = 0; k < 5; ++k) Show(room, turn * kDeg, std::nullopt);
    }
  }
  void Show(size_t room, double yaw, std::optional<ScanState> scan) {
    Observation observation;
    observation.stamp_ns = stamp_ns_ += 100'000'000;
    observation.image = {stamp_ns_, rooms_[room].View(Ers7Camera(), UpOf(4), yaw)};
    observation.scan = scan;
    observation.joints.swap(joints_);
    const FrameEstimate estimate = system_.Track(observation);
    EXPECT_EQ(estimate.stamp_ns, stamp_ns_);
    EXPECT_FALSE(estimate.pose);
    EXPECT_EQ(estimate.status, TrackingStatus::kInitializing);
  }

 private:
  System& system_;
  std::vector<CylinderWorld> rooms_;
  int64_t stamp_ns_ = 0;
  bool left_ = false;
  std::vector<JointSample> joints_;
};

std::unique_ptr<System> Make(const SystemSettings& settings = {}, const Calibration& calibration = Ers7()) {
  return MakeSystem("topo_slam", SystemSetup{calibration, 1, settings});
}

Calibration WithGyroscope() {
  Calibration calibration = Ers7();
  calibration.imu.rate_hz = 100;
  return calibration;
}

/// What it knows at its end.
PlaceGraph GraphOf(System& system) {
  const FinalEstimate end = system.Finish();
  return *FindMap<PlaceGraph>(end.maps);
}

class TopoSlamLoops : public testing::TestWithParam<bool> {};

TEST_P(TopoSlamLoops, AddsANodeForEachRoomAndClosesTheLoopWhenItIsBack) {
  const auto system = Make({{"look_around", GetParam()}});
  EXPECT_TRUE(InfoOfSystem("topo_slam").acts);
  EXPECT_TRUE(WantsScan(*system));  // its first frame is at a new place
  WalkOfRooms walk(*system);
  for (const size_t room : {0, 1, 2, 0, 3}) walk.Stay(room, 40);
  const FinalEstimate end = system->Finish();
  EXPECT_EQ(end.failure, "");
  EXPECT_TRUE(end.frames.empty());
  const PlaceGraph graph = *FindMap<PlaceGraph>(end.maps);
  ASSERT_EQ(graph.nodes.size(), 4u);
  for (const PlaceNode& node : graph.nodes) {
    EXPECT_EQ(node.bytes, 169u);
    EXPECT_EQ(node.panorama.size(), cv::Size(720, 160));
  }
  ASSERT_EQ(graph.links.size(), 4u);
  const int expected[4][3] = {{0, 1, 0}, {1, 2, 0}, {2, 0, 1}, {0, 3, 0}};
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(graph.links[k].from, expected[k][0]);
    EXPECT_EQ(graph.links[k].to, expected[k][1]);
    EXPECT_EQ(graph.links[k].loop, expected[k][2] == 1);
  }
  ASSERT_FALSE(graph.tests.empty());
  bool loop_seen = false;
  int decided = 0;
  for (const PlaceTest& test : graph.tests) {
    const bool panoramic = test.view.cols == 720;
    // What decided: a panorama with look_around, else a view.
    decided += test.matched == 0 && test.stamp_ns == graph.links[2].stamp_ns && panoramic == GetParam();
    if (panoramic && test.matched >= 0) {
      EXPECT_NEAR(test.bearing_rad, 0, 1 * kDeg);
      continue;
    }
    EXPECT_EQ(test.likelihood.size(), test.posterior.size());
    EXPECT_NEAR(std::accumulate(test.posterior.begin(), test.posterior.end(), 0.0), 1, 1e-9);
    if (test.matched != 0) continue;
    loop_seen = true;
    // The room was scanned from straight ahead; the view looks 20 degrees to the left, give or take its 3.
    EXPECT_NEAR(test.bearing_rad, 20 * kDeg, 5 * kDeg);
  }
  EXPECT_TRUE(loop_seen);
  EXPECT_EQ(decided, 1);
}
INSTANTIATE_TEST_SUITE_P(, TopoSlamLoops, testing::Bool(),
                         [](const auto& info) { return info.param ? "ByAPanorama" : "ByAView"; });

TEST(TopoSlam, RoomsThatLookTheSameAreToldApartByDeadReckoning) {
  for (const int steps : {5, 200}) {
    const auto system = Make({}, WithGyroscope());
    WalkOfRooms walk(*system, {1, 2, 1});
    walk.Stay(0, 30);
    for (const size_t room : {1, 2}) {
      walk.Step(steps);
      walk.Stay(room, 40);
    }
    // 10 steps from the first room it may be back in it; 400 steps from it it is somewhere else.
    const PlaceGraph graph = GraphOf(*system);
    EXPECT_EQ(graph.nodes.size(), steps == 5 ? 2u : 3u);
    ASSERT_EQ(graph.links.size(), 2u);
    EXPECT_EQ(graph.links[1].loop, steps == 5);
  }
}

TEST(TopoSlam, WithoutAGyroscopeNoPlaceIsOutOfReach) {
  const auto system = Make();
  WalkOfRooms walk(*system, {1, 2, 1});
  walk.Stay(0, 30);
  for (const size_t room : {1, 2}) {
    walk.Step(200);
    walk.Stay(room, 40);
  }
  EXPECT_EQ(GraphOf(*system).nodes.size(), 2u);  // it may have walked in a circle
}

TEST(TopoSlam, AStandingRobotLearnsItsGyroscopesBias) {
  TopoSlamOptions options;
  options.loop.threshold = 1000;  // no view is similar enough, so none corrects the heading
  TopoSlam slam(WithGyroscope(), options);
  const CylinderWorld room(1);
  double heading_before = 0;
  for (int frame = 0; frame < 200; ++frame) {
    Observation observation;
    observation.stamp_ns = frame * 100'000'000LL;
    const double pan = frame < 40 ? (180 - 9.5 * frame) * kDeg : 0;
    observation.image = {observation.stamp_ns, room.View(Ers7Camera(), UpOf(4), pan)};
    if (frame < 40) observation.scan = ScanState{pan, 0};
    for (int k = 0; k < 10; ++k)  // 1 degree per second
      observation.imu.push_back({observation.stamp_ns + k * 10'000'000LL, 1 * kDeg * UpOf(4), 9.81 * UpOf(4)});
    slam.Track(observation);
    if (frame == 45) heading_before = slam.heading_rad();
  }
  EXPECT_EQ(slam.graph().nodes.size(), 1u);
  EXPECT_NEAR(slam.heading_rad(), heading_before, 0.01 * kDeg);  // 15 degrees if it were not known
}

TEST(TopoSlam, IgnoresATurnBetweenTwoHalfScans) {
  const auto system = Make();
  WalkOfRooms walk(*system);
  walk.ScanByTurning(0);
  EXPECT_FALSE(WantsScan(*system));
  EXPECT_EQ(GraphOf(*system).nodes.size(), 1u);
}

TEST(TopoSlam, IsNotMisledByASingleOddView) {
  const auto system = Make();
  WalkOfRooms walk(*system);
  walk.Stay(0, 30);
  walk.Stay(1, 5);  // one test or two, of the three in a row that it takes
  walk.Stay(0, 30);
  const PlaceGraph graph = GraphOf(*system);
  EXPECT_EQ(graph.nodes.size(), 1u);
  EXPECT_TRUE(graph.links.empty());
}

TEST(TopoSlam, AddsNoNodeWhereAScanShowsAKnownPlace) {
  // No view is similar enough: it scans again and again.
  const auto system = Make({{"loop.threshold", 1000.0}});
  WalkOfRooms walk(*system);
  for (const size_t room : {0, 0, 1, 2, 0}) walk.Stay(room, 35);
  const PlaceGraph graph = GraphOf(*system);
  EXPECT_EQ(graph.nodes.size(), 3u);
  ASSERT_EQ(graph.links.size(), 3u);
  EXPECT_EQ(graph.links[2].from, 2);
  EXPECT_EQ(graph.links[2].to, 0);
  EXPECT_TRUE(graph.links[2].loop);
}

TEST(TopoSlam, SaysThatItNeedsABodyThatScans) {
  const auto system = Make({{"scan_patience_s", 2.0}});
  WalkOfRooms walk(*system);
  for (int k = 0; k < 30; ++k) walk.Show(0, 0, std::nullopt);
  const FinalEstimate end = system->Finish();
  EXPECT_THAT(end.failure, HasSubstr("asked for a scan and none came"));
  EXPECT_TRUE(FindMap<PlaceGraph>(end.maps)->nodes.empty());
}

TEST(TopoSlam, SaysHowMuchOfAScanIsMissing) {
  const auto system = Make();
  WalkOfRooms walk(*system);
  walk.Scan(0, 96);
  walk.Show(0, 0, std::nullopt);
  const std::string failure = system->Finish().failure;
  EXPECT_THAT(failure, HasSubstr("of 360 deg unseen"));
  EXPECT_EQ(failure.find('\n'), std::string::npos);
}

TEST(TopoSlam, RefusesWhatItCannotWorkWith) {
  EXPECT_THROW(Make({{"height_px", 10}}), BadInput);  // too small for level 4
  EXPECT_THROW(Make({{"width_px", 60}}), BadInput);   // views are too narrow
  EXPECT_THROW(Make({{"loop.threshold", 0.2}}), BadOption);
  Calibration calibration = Ers7();
  calibration.standing.reset();
  EXPECT_THROW(MakeSystem("topo_slam", SystemSetup{calibration, 1, {}}), BadInput);
}

}  // namespace
}  // namespace gaitcam
