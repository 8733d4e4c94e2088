#include "algorithms/slam/map_merger.h"

#include <gtest/gtest.h>

#include "algorithms/slam/hybrid_slam.h"
#include "tests/algorithms/slam/taught_room.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

/// What a straight drive along the room's x axis teaches, from another start.
RouteMap Session(const PlanarPose& start, uint64_t seed) {
  HybridSlamOptions options;
  options.sight.sensitivity = 4;
  options.model_m = 0.1;
  HybridSlam slam(DepthAndWheels(), options, seed);
  RoomBase base(start);
  for (int frame = 0; frame < 12; ++frame) {
    slam.Track(base.Look());
    base.Drive({0.4, 0, 0});
  }
  slam.Finish();
  return slam.Learned();
}

MapMergeOptions OfSmallPictures() {
  MapMergeOptions options;
  options.links.min_inliers = 10;
  return options;
}

const PlanarPose kOtherStart({-1.5, -0.1}, 0.1);

TEST(MapMerger, PutsTheSecondSessionWhereItWasDriven) {
  const RouteMap first = *TaughtLane(), second = Session(kOtherStart, 2);
  const auto both = MergeRouteMaps(first, second, DepthAndWheels(), OfSmallPictures(), 1);
  ASSERT_TRUE(both);
  EXPECT_EQ(both->sessions, (std::vector<int>{0, int(first.views.size())}));
  EXPECT_EQ(both->views.size(), first.views.size() + second.views.size());
  const Pose X_BC = DepthAndWheels().odometry.X_BC;
  const Pose X_true = (kTaughtStart.Lifted() * X_BC).Inverse() * kOtherStart.Lifted() * X_BC;
  const GraphNode& start = both->graph.nodes[size_t(both->sessions[1])];
  // As of hybrid_slam's own test: half a pixel is 7 mm on a wall 3 m away, and fits are of dozens of features.
  EXPECT_LT((start.X_WC.translation - X_true.translation).norm(), 0.02);
  EXPECT_LT(RotationAngle(start.X_WC.rotation, X_true.rotation), 0.01);
  EXPECT_EQ(start.stamp_ns, second.graph.nodes.front().stamp_ns + kSessionApart_ns);
}

TEST(MapMerger, AThirdSessionFindsEither) {
  const auto two = MergeRouteMaps(*TaughtLane(), Session(kOtherStart, 2), DepthAndWheels(), OfSmallPictures(), 1);
  ASSERT_TRUE(two);
  const auto three = MergeRouteMaps(*two, Session(kTaughtStart, 3), DepthAndWheels(), OfSmallPictures(), 1);
  ASSERT_TRUE(three);
  ASSERT_EQ(three->sessions.size(), 3u);
  EXPECT_LT(three->graph.nodes[size_t(three->sessions[2])].X_WC.translation.norm(), 0.02) << "it began as the first";
}

TEST(MapMerger, WhatNeverMetIsNotJoined) {
  const RouteMap elsewhere = Session({{1.0, 0}, 3.1}, 2);  // along the same lane, facing the other wall
  EXPECT_FALSE(MergeRouteMaps(*TaughtLane(), elsewhere, DepthAndWheels(), OfSmallPictures(), 1));
}

TEST(MapMerger, RefusesAMapOfAnotherCamera) {
  Calibration other = DepthAndWheels();
  other.camera = CameraModel::FromHorizontalFov(240, 180, 90);
  const std::string error = ErrorOf([&] { MergeRouteMaps(*TaughtLane(), *TaughtLane(), other, OfSmallPictures(), 1); });
  EXPECT_NE(error.find("learned with a camera of"), std::string::npos) << error;
}

}  // namespace
}  // namespace gaitcam
