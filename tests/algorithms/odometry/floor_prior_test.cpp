#include "algorithms/odometry/floor_prior.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

/// Points of a camera's frame on a floor `height` below it, the camera pitched down; with some of a wall.
std::vector<Eigen::Vector3d> FloorAndWall(double height, double pitch, int floor_points, int wall_points) {
  RandomStream random(1, "floor");
  const Eigen::Matrix3d R = RotX(pitch);  // x right, y down: positive turns the view up
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < floor_points; ++i) {
    points.push_back(
        R * Eigen::Vector3d(random.Uniform(-1, 1), height * (1 + 0.01 * random.Normal()), random.Uniform(1, 4)));
  }
  for (int i = 0; i < wall_points; ++i) {
    points.push_back(R * Eigen::Vector3d(random.Uniform(-1, 1), random.Uniform(0.1, 0.9) * height, 4));
  }
  return points;
}

TEST(FindFloor, HeightAndNormalAmongWallPoints) {
  for (const double pitch : {-0.3, 0.0, 0.2}) {
    RandomStream random(2, "ransac");
    const auto plane = FindFloor(FloorAndWall(0.3, pitch, 120, 60), random);
    ASSERT_TRUE(plane);
    EXPECT_NEAR(plane->height, 0.3, 0.003);  // 1 % noise on 120 points
    const Eigen::Vector3d up = RotX(pitch) * Eigen::Vector3d(0, -1, 0);
    EXPECT_LT(std::acos(std::min(1.0, plane->normal.dot(up))), 0.01);
  }
}

TEST(FindFloor, AWallOrASlopeIsNoFloor) {
  RandomStream random(3, "ransac");
  EXPECT_FALSE(FindFloor(FloorAndWall(0.3, 0, 0, 200), random));
  EXPECT_FALSE(FindFloor(FloorAndWall(0.3, 0.8, 200, 0), random)) << "46 degrees";
}

TEST(FindFloor, ATableWithPointsBelowIsNoFloor) {
  std::vector<Eigen::Vector3d> points = FloorAndWall(0.3, 0, 100, 0);
  RandomStream random(4, "points");
  for (int i = 0; i < 39; ++i)
    points.push_back({random.Uniform(-1, 1), random.Uniform(0.5, 0.9), random.Uniform(1, 4)});
  EXPECT_FALSE(FindFloor(points, random));
}

TEST(FloorPrior, KnowsNothingBeforeAFloorWasSeen) { EXPECT_FALSE(FloorPrior().DepthAt(Pose(), {0, 0.3})); }

/// A map of two keyframes whose landmarks lie on a floor 0.5 below the camera.
struct FloorMap {
  KeyframeMap map{KeyframeMapOptions()};
  Pose last;
  FloorMap() {
    RandomStream random(5, "map");
    const Pose second(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.2, 0, 0));
    FrameView a, b;
    b.X_WC = second;
    std::vector<LandmarkMatch> matches;
    for (int i = 0; i < 120; ++i) {
      const Eigen::Vector3d p(random.Uniform(-0.5, 0.7), 0.5, random.Uniform(1, 3));
      for (FrameView* view : {&a, &b}) {
        const Eigen::Vector3d p_C = view->X_WC.Inverse() * p;
        view->xy.push_back(p_C.hnormalized());
        view->sigma.push_back(0.002);
        view->features.keypoints.emplace_back();
      }
      matches.push_back({i, i});
    }
    a.features.descriptors = b.features.descriptors = cv::Mat::zeros(120, 4, CV_32FC1);
    const auto none = [](const Pose&, const Eigen::Vector2d&) { return std::optional<DepthPrior>(); };
    map.AddKeyframe(a, {}, 2, none);
    map.AddKeyframe(b, matches, 2, none);
    last = b.X_WC;
  }
};

TEST(FloorPrior, TellsTheInverseDepthOfWhatLiesOnTheFloor) {
  const FloorMap floor;
  FloorPrior prior;
  RandomStream random(6, "ransac");
  prior.Update(floor.map, floor.last, random);
  ASSERT_TRUE(prior.height());
  const double scale = *prior.height() / 0.5;  // two views have no scale of their own: the map's priors chose one
  const auto at = prior.DepthAt(floor.last, {0.1, 0.4});
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->rho * scale, 0.8, 0.02);  // y / z = 0.4 at y = 0.5
  EXPECT_GT(at->sigma, 0.05 * at->rho) << "a walking camera's height varies";
  EXPECT_FALSE(prior.DepthAt(floor.last, {0.1, -0.2})) << "above the horizon";
  EXPECT_FALSE(prior.DepthAt(floor.last, {0.1, 0.01})) << "too near the horizon to tell";
}

TEST(FloorPrior, BehindAWallsFootThereIsNoFloor) {
  FloorMap floor;
  const auto none = [](const Pose&, const Eigen::Vector2d&) { return std::optional<DepthPrior>(); };
  FrameView view;  // sees the same floor again, and a poster on a wall 2 away
  std::vector<LandmarkMatch> matches;
  const int old = int(floor.map.landmarks().size());
  for (const double x : {0.0, 0.2, 0.4, 0.6}) {
    view.X_WC = Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0));
    view.xy.clear();
    view.sigma.clear();
    matches.clear();
    for (int i = 0; i < 60; ++i) {
      const bool is_floor = i < 48;
      const Eigen::Vector3d p(0.2 + 0.02 * (i % 12), is_floor ? 0.5 : 0.1, is_floor ? 1.0 + 0.01 * i : 2.0);
      view.xy.push_back((view.X_WC.Inverse() * p).hnormalized());
      view.sigma.push_back(0.002);
      if (x > 0) matches.push_back({old + i, i});
    }
    view.features.descriptors = cv::Mat::zeros(60, 4, CV_32FC1);
    floor.map.AddKeyframe(view, matches, 2, none);
  }
  FloorPrior prior;
  RandomStream random(7, "ransac");
  prior.Update(floor.map, view.X_WC, random);
  ASSERT_TRUE(prior.height());
  const double u = (0.3 - view.X_WC.translation.x()) / 2.0;  // towards the poster
  EXPECT_TRUE(prior.DepthAt(view.X_WC, {u, 0.4})) << "the floor before the wall";
  EXPECT_FALSE(prior.DepthAt(view.X_WC, {u, 0.17})) << "2.9 away: the wall is in between";
  EXPECT_TRUE(prior.DepthAt(view.X_WC, {u + 0.5, 0.17})) << "beside it";
}

/// What gravity and a measurement tell of a camera whose y axis points down.
Carried LevelCamera() { return {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d::Zero()}; }
CarriedHeight FloorBelow(double height) { return {height, 0.02, Eigen::Vector3d(0, -1, 0), {}}; }

TEST(FloorPriorWithGravity, TheMeanOfTheFirstMeasurementsIsTheHeightForGood) {
  const FloorMap floor;
  FloorPrior prior;
  prior.Update(floor.map, floor.last, LevelCamera(), std::nullopt);
  EXPECT_FALSE(prior.height()) << "the map alone would have told one";
  for (const double height : {0.48, 0.52, 0.49, 0.51, 0.55})
    prior.Update(floor.map, floor.last, LevelCamera(), FloorBelow(height));
  ASSERT_TRUE(prior.height());
  EXPECT_NEAR(*prior.height(), 0.51, 1e-12);
  prior.Update(floor.map, floor.last, LevelCamera(), FloorBelow(0.2));
  EXPECT_NEAR(*prior.height(), 0.51, 1e-12) << "a map that shrinks is held, not followed";
  prior.Clear();
  prior.Update(floor.map, floor.last, LevelCamera(), FloorBelow(0.2));
  EXPECT_NEAR(*prior.height(), 0.2, 1e-12) << "a new map has a new unit";
}

/// Landmarks that happen to lie on a slope: a fit without gravity takes it for the floor.
TEST(FloorPriorWithGravity, ASlopeOfLandmarksDoesNotTiltTheFloor) {
  const FloorMap floor;
  const Pose tilted(Eigen::Quaterniond(RotX(0.3)), floor.last.translation);
  Carried carried = LevelCamera();
  carried.up_W = RotX(0.3) * carried.up_W;  // seen from the vertical, the map's floor is a slope of 17 degrees
  FloorPrior prior, without_gravity;
  CarriedHeight before = FloorBelow(0.5);
  before.normal_W = carried.up_W;
  prior.Update(floor.map, tilted, carried, before);
  for (int k = 0; k < 10; ++k) prior.Update(floor.map, tilted, carried, std::nullopt);
  EXPECT_LT(std::acos(std::min(1.0, prior.normal().dot(carried.up_W))), 1e-6);
  RandomStream random(8, "ransac");
  without_gravity.Update(floor.map, tilted, random);
  ASSERT_TRUE(without_gravity.height()) << "the landmarks do make a floor";
  EXPECT_GT(std::acos(std::min(1.0, without_gravity.normal().dot(carried.up_W))), 0.25);
}

/// Else a map that shrinks by a quarter loses what would hold it.
TEST(FloorPriorWithGravity, AMapsOwnFloorDoesNotHideTheFloorWhenItsUnitDrifts) {
  const FloorMap floor;
  FloorPrior prior;
  RandomStream random(6, "ransac");
  prior.Update(floor.map, floor.last, random);
  const double height = *prior.height();
  prior.Clear();
  for (int k = 0; k < 5; ++k) prior.Update(floor.map, floor.last, LevelCamera(), FloorBelow(1.6 * height));
  prior.Update(floor.map, floor.last, LevelCamera(), FloorBelow(height));
  const auto at = prior.DepthAt(floor.last, {0.1, 0.2});
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->rho * 1.6 * height, 0.2, 1e-4) << "of the floor where it was at first; adjustment turned the camera";
}

/// A map in which three keyframes saw the points.
KeyframeMap MapOf(const std::vector<Eigen::Vector3d>& points, Pose& last) {
  const auto none = [](const Pose&, const Eigen::Vector2d&) { return std::optional<DepthPrior>(); };
  KeyframeMap map{KeyframeMapOptions()};
  for (const double x : {0.0, 0.3, 0.1}) {
    FrameView view;
    view.X_WC = last = Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0));
    std::vector<LandmarkMatch> matches;
    for (int i = 0; i < int(points.size()); ++i) {
      view.xy.push_back((view.X_WC.Inverse() * points[size_t(i)]).hnormalized());
      view.sigma.push_back(0.0002);
      if (x > 0) matches.push_back({i, i});
    }
    view.features.descriptors = cv::Mat::zeros(int(points.size()), 4, CV_32FC1);
    map.AddKeyframe(view, matches, 1, none);
  }
  return map;
}

TEST(FloorPriorWithGravity, WhatStandsOnTheFloorHidesItAsFarAsItIsHigh) {
  Pose last;
  std::vector<Eigen::Vector3d> box;  // its front 1 away, 0.2 high, seen from 0.5
  for (int i = 0; i < 30; ++i) box.emplace_back(0.01 * i, 0.3 + 0.002 * (i % 5), 1);
  const KeyframeMap map = MapOf(box, last);
  FloorPrior prior;
  prior.Update(map, last, LevelCamera(), FloorBelow(0.5));
  const double u = 0.15 - last.translation.x();
  EXPECT_TRUE(prior.DepthAt(last, {u, 0.55})) << "0.9 away, before it";
  EXPECT_FALSE(prior.DepthAt(last, {u, 0.4})) << "1.25 away, behind it";
  EXPECT_TRUE(prior.DepthAt(last, {u, 0.25})) << "2 away, seen over it";
}

/// Blur and repeated texture make landmarks in mid-air.
TEST(FloorPriorWithGravity, WhatTheFloorIsSeenThroughDoesNotHideIt) {
  Pose last;
  std::vector<Eigen::Vector3d> in_mid_air;
  for (int i = 0; i < 30; ++i) in_mid_air.emplace_back(0.01 * i, 0.1 + 0.002 * (i % 5), 1);
  const KeyframeMap map = MapOf(in_mid_air, last);
  const double u = 0.15 - last.translation.x();
  CarriedHeight measured = FloorBelow(0.5);
  FloorPrior prior;
  prior.Update(map, last, LevelCamera(), measured);
  EXPECT_FALSE(prior.DepthAt(last, {u, 0.2})) << "2.5 away, behind them";
  for (int i = 0; i < 6; ++i) {
    const double z = 2 + 0.1 * i;
    measured.seen_on_floor_W.push_back(last.translation + Eigen::Vector3d(u * z, 0.5, z));
  }
  prior.Update(map, last, LevelCamera(), measured);
  EXPECT_TRUE(prior.DepthAt(last, {u, 0.2}));
}

}  // namespace
}  // namespace gaitcam
