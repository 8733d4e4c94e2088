#include "algorithms/slam/hybrid_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "algorithms/core/units.h"
#include "tests/algorithms/slam/taught_room.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

HybridDriveOptions ToGoal(double x_m, double y_m = 0) {
  HybridDriveOptions options;
  options.goal_x_m = x_m;
  options.goal_y_m = y_m;
  options.sight.sensitivity = 4;
  options.localizer.relocalise_inliers = 15;  // a small picture has few features
  return options;
}

/// A drive in the room, in which something may befall the robot before each frame, or what it sees.
struct Drive {
  std::vector<PlanarPose> path;  ///< True, at each frame.
  TaughtDrive said;
  std::vector<FrameEstimate> answers;
  bool ended = false;

  using Befalls = std::function<void(int frame, RoomBase& base)>;
  using Seen = std::function<void(int frame, const PlanarPose& X_WB, Observation& observation)>;

  /// @param late by so many frames it answers its commands.
  Drive(const HybridDriveOptions& options, const PlanarPose& start, int most_frames, const Befalls& befalls = {},
        const Seen& seen = {}, const std::shared_ptr<const RouteMap>& map = TaughtLane(), size_t late = 0) {
    std::deque<Velocity> on_their_way(late);
    HybridDrive drive(DepthAndWheels(), map, options, 1);
    RoomBase base(start);
    for (int frame = 0; frame < most_frames && !ended; ++frame) {
      if (befalls) befalls(frame, base);
      Observation observation = base.Look();
      if (seen) seen(frame, base.X_WB(), observation);
      answers.push_back(drive.Track(observation));
      path.push_back(base.X_WB());
      ended = std::holds_alternative<EndWalk>(drive.command());
      if (ended) break;
      on_their_way.push_back(std::get<Velocity>(drive.command()));
      base.Drive(on_their_way.front());
      on_their_way.pop_front();
    }
    said = drive.drive();
  }

  Eigen::Vector2d TrueInF(int frame) const { return kTaughtStart.Inverse() * path[size_t(frame)].position; }
  int Count(DriveState state) const {
    return int(std::count_if(said.steps.begin(), said.steps.end(), [&](const auto& s) { return s.state == state; }));
  }
};

// As of hybrid_slam's own test: a pixel is 14 mm on a wall 3 m away, fits are of dozens of features.
constexpr double kRoomTolerance_m = 0.02;

TEST(HybridDrive, DrivesBackToTheTaughtWayAndStopsAtItsGoal) {
  const Drive drive(ToGoal(1.2), kTaughtStart * PlanarPose({0.05, 0.08}, -0.08), 60);
  ASSERT_TRUE(drive.ended);
  EXPECT_EQ(drive.said.steps.back().state, DriveState::kArrived);
  EXPECT_TRUE(drive.said.steps.front().found);
  const int last = int(drive.path.size()) - 1;
  // Views are 0.1 m apart, and it stops as soon as 3 cm are left.
  EXPECT_LT((drive.TrueInF(last) - Eigen::Vector2d(1.2, 0)).norm(), 0.05 + 0.03 + kRoomTolerance_m);
  EXPECT_LT(std::abs(drive.TrueInF(last).y()), kRoomTolerance_m) << "it began 8 cm beside the way";
  EXPECT_LT(std::abs(drive.path.back().heading - kTaughtStart.heading), 0.02);
  for (int i = 0; i <= last; ++i) {
    EXPECT_LT((drive.said.steps[size_t(i)].X_FB.position - drive.TrueInF(i)).norm(), kRoomTolerance_m) << i;
    EXPECT_TRUE(drive.answers[size_t(i)].pose.has_value()) << i;
  }
}

/// A column that stands in the way at so many metres of the taught floor frame, and covers a third of the view.
void PutColumn(double x_m, const PlanarPose& X_WB, cv::Mat& depth) {
  const Pose X_FC = (kTaughtStart.Inverse() * X_WB).Lifted() * DepthAndWheels().odometry.X_BC;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = depth.cols / 3; u < 2 * depth.cols / 3; ++u) {
      const double ahead = (X_FC.R() * kCamera.Unproject({double(u), double(v)})).x();
      if (ahead <= 0) continue;
      depth.at<float>(v, u) = std::min(depth.at<float>(v, u), float((x_m - X_FC.translation.x()) / ahead));
    }
  }
}

TEST(HybridDrive, WaitsForWhatStandsInItsWayAndGoesOnWhenItIsGone) {
  constexpr double kColumn_m = 1.3;
  constexpr int kComes = 4, kGone = 30;
  const auto column = [](int frame, const PlanarPose& X_WB, Observation& observation) {
    if (frame >= kComes && frame < kGone) PutColumn(kColumn_m, X_WB, observation.depth->pixels);
  };
  const Drive drive(ToGoal(1.2), kTaughtStart, 90, {}, column);
  ASSERT_TRUE(drive.ended);
  EXPECT_GT(drive.Count(DriveState::kWaiting), 10);
  const double stood_m = drive.TrueInF(kGone).x();
  EXPECT_LE(stood_m, kColumn_m - 0.52) << "body and clearance";
  EXPECT_GT(stood_m, kColumn_m - 0.52 - 0.25);
  EXPECT_LT((drive.path[kGone].position - drive.path[kGone - 5].position).norm(), 0.01);
}

TEST(HybridDrive, KeepsItsClearanceThoughTheBodyAnswersLate) {
  constexpr double kColumn_m = 1.3;
  constexpr int kFrames = 40;
  constexpr size_t kLate = 4;
  const auto column = [](int, const PlanarPose& X_WB, Observation& observation) {
    PutColumn(kColumn_m, X_WB, observation.depth->pixels);
  };
  const auto comes_to = [&](double late_s) {
    HybridDriveOptions options = ToGoal(1.2);
    options.late_s = late_s;
    const Drive drive(options, kTaughtStart, kFrames, {}, column, TaughtLane(), kLate);
    double farthest_m = 0;
    for (int i = 0; i < kFrames; ++i) farthest_m = std::max(farthest_m, drive.TrueInF(i).x());
    return farthest_m;
  };
  const double clear_m = kColumn_m - 0.52;  // body and clearance
  EXPECT_GT(comes_to(0), clear_m + 0.05);
  EXPECT_LE(comes_to(kLate * RoomBase::kFrame_s), clear_m);
  EXPECT_GT(comes_to(kLate * RoomBase::kFrame_s), clear_m - 0.25);
}

TEST(HybridDrive, FindsItselfAgainWhereItWasCarriedTo) {
  const auto carried = [](int frame, RoomBase& base) {
    if (frame == 6) base.CarryTo(kTaughtStart * PlanarPose({0.1, 0}, 0.05));
  };
  const Drive drive(ToGoal(1.4), kTaughtStart * PlanarPose({0.8, 0}, 0), 100, carried);
  ASSERT_TRUE(drive.ended);
  EXPECT_EQ(std::count_if(drive.said.steps.begin(), drive.said.steps.end(), [](const auto& s) { return s.found; }), 2);
  EXPECT_EQ(drive.said.routes.size(), 2u);
  EXPECT_LT((drive.TrueInF(int(drive.path.size()) - 1) - Eigen::Vector2d(1.4, 0)).norm(), 0.1 + kRoomTolerance_m);
}

TEST(HybridDrive, TrustsItsWheelsForSoFarOnlyAndThenLooksAround) {
  HybridDriveOptions options = ToGoal(1.4);
  options.blind_m = 0.35;
  const auto dark = [](int frame, const PlanarPose&, Observation& observation) {
    if (frame >= 3) observation.image.pixels.setTo(0);
  };
  constexpr int kEnd = 260;
  const Drive drive(options, kTaughtStart, kEnd, {}, dark);
  EXPECT_FALSE(drive.ended);
  const auto blind_m = [&](int frame) { return (drive.path[size_t(frame)].position - drive.path[2].position).norm(); };
  constexpr double kTwoFrames_m = 2 * 0.3 * 0.25;
  // It looks around for 21 s, 84 frames, goes on for as far again, looks around once more, and stands.
  EXPECT_GT(blind_m(30), 0.35);
  EXPECT_LT(blind_m(30), 0.35 + kTwoFrames_m);
  EXPECT_EQ(drive.path[30].position, drive.path[80].position);
  EXPECT_GT(std::abs(WrapAngle(drive.path[50].heading - drive.path[30].heading)), 1);
  int goes_on = 30;
  while (goes_on < kEnd - 1 && drive.path[size_t(goes_on)].position == drive.path[30].position) ++goes_on;
  EXPECT_NEAR(drive.path[size_t(goes_on)].heading - drive.path[2].heading, 2 * kPi, 0.1) << "a frame or two more";
  EXPECT_GT(blind_m(kEnd - 1), 0.7);
  EXPECT_LT(blind_m(kEnd - 1), 2 * (0.35 + kTwoFrames_m));
  EXPECT_EQ(drive.path[kEnd - 1].heading, drive.path[kEnd - 10].heading);
  EXPECT_EQ(drive.said.steps.back().state, DriveState::kSearching);
}

TEST(HybridDrive, StandsAsLongAsItDoesNotKnowWhereItIs) {
  const auto dark = [](int, const PlanarPose&, Observation& observation) { observation.image.pixels.setTo(0); };
  const Drive drive(ToGoal(1.2), kTaughtStart, 5, {}, dark);
  EXPECT_EQ(drive.Count(DriveState::kSearching), 5);
  EXPECT_EQ(drive.path.back().position, drive.path.front().position);
  for (const FrameEstimate& answer : drive.answers) EXPECT_EQ(answer.status, TrackingStatus::kInitializing);
}

TEST(HybridDrive, CountsOnItsWheelsForPredictionsNotForPoses) {
  const auto dark = [](int frame, const PlanarPose&, Observation& observation) {
    if (frame >= 5 && frame < 10) observation.image.pixels.setTo(0);
  };
  const Drive drive(ToGoal(1.2), kTaughtStart, 12, {}, dark);
  for (int i = 0; i < 12; ++i) {
    const bool blind = i >= 5 && i < 10;
    EXPECT_EQ(drive.answers[size_t(i)].pose.has_value(), !blind) << i;
    EXPECT_EQ(drive.answers[size_t(i)].predicted.has_value(), blind) << i;
    EXPECT_EQ(drive.said.steps[size_t(i)].confirmed, !blind) << i;
  }
}

TEST(HybridDrive, ArrivesInTheDarkOnceNothingSaysOtherwise) {
  constexpr int kDark = 12;
  const auto dark = [](int frame, const PlanarPose&, Observation& observation) {
    if (frame >= kDark) observation.image.pixels.setTo(0);
  };
  const Drive drive(ToGoal(1.2), kTaughtStart, 80, {}, dark);
  ASSERT_TRUE(drive.ended);
  EXPECT_FALSE(drive.said.steps.back().confirmed);
  // It has stood there and looked for itself in the whole map: since frame 12 for 12 frames, and then for four.
  EXPECT_GE(int(drive.path.size()), kDark + 12 + 4);
  EXPECT_LT((drive.TrueInF(int(drive.path.size()) - 1) - Eigen::Vector2d(1.2, 0)).norm(), 0.1 + kRoomTolerance_m);
}

constexpr double kSecond_m = 5;

/// The lane as if it were there twice, the second time so many metres ahead; of the first only some views are known.
std::shared_ptr<const RouteMap> LaneTwice(size_t known_views) {
  const std::shared_ptr<const RouteMap> once = TaughtLane();
  RouteMap twice = *once;
  twice.graph.links.clear();
  const Pose ahead = once->X_BC.Inverse() * PlanarPose({kSecond_m, 0}, 0).Lifted() * once->X_BC;
  for (size_t v = 0; v < once->graph.nodes.size(); ++v) {
    if (v >= known_views) twice.views[v] = {};
    twice.graph.nodes.push_back(once->graph.nodes[v]);
    twice.graph.nodes.back().X_WC = ahead * once->graph.nodes[v].X_WC;
    twice.graph.nodes.back().stamp_ns += kSessionApart_ns;
  }
  twice.views.insert(twice.views.end(), once->views.begin(), once->views.end());
  return std::make_shared<const RouteMap>(twice);
}

TEST(HybridDrive, IsNotSureWhereItIsAsLongAsTwoPlacesLookTheSame) {
  HybridDriveOptions options = ToGoal(kSecond_m + 1.2);
  options.localizer.near_m = 0.25;  // from farther on, a view of so small a room still shows much the same
  const Drive drive(options, kTaughtStart, 60, {}, {}, LaneTwice(5));
  ASSERT_TRUE(drive.ended);
  int unsure = 0;
  for (size_t i = 0; i < drive.path.size(); ++i) {
    const DriveStep& step = drive.said.steps[i];
    unsure += step.places == 2;
    EXPECT_EQ(step.confirmed, drive.answers[i].pose.has_value()) << i;
    if (step.places == 2) EXPECT_TRUE(!step.confirmed && drive.answers[i].predicted.has_value()) << i;
    if (!step.confirmed) continue;
    const Eigen::Vector2d there = drive.TrueInF(int(i)) + Eigen::Vector2d(kSecond_m, 0);
    EXPECT_LT((step.X_FB.position - there).norm(), kRoomTolerance_m) << i;
  }
  // Both have views up to 0.64 m, 0.16 m apart, which reach 0.25 m farther. A frame is 0.06 m; half of what was
  // explained is forgotten in four frames.
  EXPECT_GT(unsure, 5);
  EXPECT_LT(unsure, (0.64 + 0.25) / 0.06 + 10);
  EXPECT_EQ(drive.said.steps[1].state, DriveState::kDriving) << "the way is the same from both";
  EXPECT_EQ(drive.said.steps.back().state, DriveState::kArrived);
}

TEST(HybridDrive, DoesNotSayThatItArrivedWhereItMayBeElsewhere) {
  constexpr int kFrames = 60;
  const Drive drive(ToGoal(kSecond_m + 0.5), kTaughtStart, kFrames, {}, {}, LaneTwice(TaughtLane()->views.size()));
  EXPECT_FALSE(drive.ended);
  for (const DriveStep& step : drive.said.steps) {
    EXPECT_EQ(step.places, 2);
    EXPECT_FALSE(step.confirmed);
  }
  EXPECT_GT(drive.TrueInF(kFrames - 1).x(), 0.4) << "it goes on while the way is the same";
}

const PlanarPose kOtherWall({0, 0}, kPi / 2);  // from the taught start

/// The lane, and what the wall beside it looks like, so many metres on from its start, as if it were far ahead.
std::shared_ptr<const RouteMap> LaneAndAFalseView(double on_m = 0) {
  RouteMap map = *TaughtLane();
  HybridSlamOptions options;
  options.sight.sensitivity = 4;
  options.model_m = 0.1;
  HybridSlam slam(DepthAndWheels(), options, 1);
  RoomBase base(kTaughtStart * PlanarPose({on_m, 0}, 0) * kOtherWall);
  for (int frame = 0; frame < 5; ++frame) {
    slam.Track(base.Look());
    base.Drive({0.4, 0, 0});
  }
  slam.Finish();
  const RouteMap wall = slam.Learned();
  map.graph.nodes.push_back(wall.graph.nodes.front());
  map.graph.nodes.back().X_WC = map.X_BC.Inverse() * PlanarPose({kSecond_m, 0}, 0).Lifted() * map.X_BC;
  map.graph.nodes.back().stamp_ns += kSessionApart_ns;
  map.views.push_back(wall.views.front());
  return std::make_shared<const RouteMap>(map);
}

TEST(HybridDrive, DoesNotBelieveASingleViewAgainstItsWheels) {
  constexpr int kDark = 3, kFalse = 17, kLight = 20;
  const auto deceived = [&](int frame, const PlanarPose&, Observation& observation) {
    if (frame < kDark || frame >= kLight) return;
    const Observation wall = RoomBase(kTaughtStart * kOtherWall).Look();
    observation.image.pixels = wall.image.pixels;
    observation.depth->pixels = wall.depth->pixels;
    if (frame != kFalse) observation.image.pixels.setTo(0);
  };
  const Drive drive(ToGoal(1.4), kTaughtStart, 100, {}, deceived, LaneAndAFalseView());
  ASSERT_TRUE(drive.ended);
  EXPECT_EQ(drive.said.steps[kFalse].places, 2);
  for (size_t i = 0; i < drive.path.size(); ++i) {
    const DriveStep& step = drive.said.steps[i];
    EXPECT_LT((step.X_FB.position - drive.TrueInF(int(i))).norm(), kRoomTolerance_m) << i;
    if (i >= kDark && i < kLight) EXPECT_FALSE(step.confirmed) << i;
  }
  EXPECT_EQ(drive.said.steps.back().state, DriveState::kArrived);
}

/// As it looks around, the map shows the wall beside it elsewhere alone, and what is ahead of it here.
TEST(HybridDrive, LooksOnWhereItsOwnPlaceHasNoViewToSpeakForIt) {
  HybridDriveOptions options = ToGoal(1.4);
  options.blind_m = 0.35;
  constexpr double kStops_m = 0.48;
  constexpr int kDark = 3;
  const auto dark_ahead = [](int frame, const PlanarPose& X_WB, Observation& observation) {
    const bool turned = std::abs(WrapAngle(X_WB.heading - kTaughtStart.heading)) > 1.2;
    if (frame >= kDark && frame < 60 && !turned) observation.image.pixels.setTo(0);
  };
  const Drive drive(options, kTaughtStart, 200, {}, dark_ahead, LaneAndAFalseView(kStops_m));
  ASSERT_TRUE(drive.ended);
  int between = 0;
  for (size_t i = 0; i < drive.path.size(); ++i) {
    const DriveStep& step = drive.said.steps[i];
    between += step.places == 2;
    EXPECT_LT((step.X_FB.position - drive.TrueInF(int(i))).norm(), kRoomTolerance_m) << i;
  }
  // It turns by 0.06 rad a frame, and the wall fits half a radian to either side. Half of what was explained is
  // forgotten in four frames.
  EXPECT_GT(between, 10);
  EXPECT_EQ(drive.said.steps.back().state, DriveState::kArrived);
}

TEST(HybridDrive, IsTheSameTwice) {
  const Drive a(ToGoal(0.5), kTaughtStart, 8), b(ToGoal(0.5), kTaughtStart, 8);
  ASSERT_EQ(a.path.size(), b.path.size());
  for (size_t i = 0; i < a.path.size(); ++i) EXPECT_EQ(a.path[i].position, b.path[i].position);
}

TEST(HybridDrive, RefusesWhatItCannotDriveBy) {
  const auto error = [](const Calibration& calibration, const std::shared_ptr<const RouteMap>& map,
                        const HybridDriveOptions& options) {
    return ErrorOf([&] { HybridDrive(calibration, map, options, 1); });
  };
  const auto says = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  says(error(DepthAndWheels(), nullptr, ToGoal(1)), "needs a map to drive by");
  says(error(DepthAndWheels(), TaughtLane(), ToGoal(1, 3)), "the goal is off the map");
  Calibration other = DepthAndWheels();
  other.odometry.rate_hz = 0;
  says(error(other, TaughtLane(), ToGoal(1)), "needs the body's odometry");
  other = DepthAndWheels();
  other.camera = CameraModel::FromHorizontalFov(240, 180, 90);
  says(error(other, TaughtLane(), ToGoal(1)), "learned with a camera of 240 x 180");
  for (int CameraModel::*side : {&CameraModel::width_px, &CameraModel::height_px}) {
    other.camera = DepthAndWheels().camera;
    other.camera.*side -= 20;
    says(error(other, TaughtLane(), ToGoal(1)), "learned with a camera of 240 x 180");
  }
  HybridDriveOptions options = ToGoal(1);
  options.sight.feature = "orb";
  says(error(DepthAndWheels(), TaughtLane(), options), "learned with feature");
  RouteMap empty = *TaughtLane();
  empty.views.assign(empty.views.size(), {});
  says(error(DepthAndWheels(), std::make_shared<const RouteMap>(empty), ToGoal(1)), "shows nothing");
}

}  // namespace
}  // namespace gaitcam
