#include "algorithms/slam/taught_ways.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// A camera that stands where its body does, so that planar poses of the body are the map's.
struct MapMaker {
  RouteMap map;

  MapMaker& View(double x, double y, double heading_deg) {
    const Pose X_WC = PlanarPose({x, y}, kRadPerDeg * heading_deg).Lifted();
    map.graph.nodes.push_back({int64_t(map.graph.nodes.size()), X_WC, {}});
    return *this;
  }
  MapMaker& Link(int from, int to, bool loop = false, double trust = 1) {
    map.graph.links.push_back({from, to, Pose(), Matrix6d::Identity(), loop, trust, false});
    return *this;
  }
  /// Views every metre along x, one after the other.
  MapMaker& Lane(double y, double first_x, double last_x, double heading_deg) {
    const double step = last_x > first_x ? 1 : -1;
    for (double x = first_x; (last_x - x) * step >= 0; x += step) View(x, y, heading_deg);
    return *this;
  }
};

TEST(TaughtWays, GoInTheDirectionInWhichTheyWereTaught) {
  const TaughtWays ways(MapMaker().Lane(0, 0, 4, 0).map);
  EXPECT_EQ(ways.Shortest(1, 3), (std::vector<int>{1, 2, 3}));
  EXPECT_TRUE(ways.Shortest(3, 1).empty()) << "there the robot would see what the map never showed";
  EXPECT_EQ(ways.Shortest(2, 2), std::vector<int>{2});
}

TEST(TaughtWays, ChangeFromPassToPassWhereALoopJoinsThem) {
  // Round a square of 4 m and along its first side again: views 0 to 4, back to 12, and 13 to 17 over 0 to 4.
  MapMaker maker;
  maker.Lane(0, 0, 4, 0).View(4, 2, 90).Lane(4, 4, 0, 180).View(0, 2, -90).Lane(0.1, 0, 4, 0);
  const int again = 14;  // at (2, 0.1)
  ASSERT_NEAR(TaughtWays(maker.map).At(again).position.x(), 2, 1e-9);
  EXPECT_EQ(TaughtWays(maker.map).Shortest(0, 3).size(), 4u);
  EXPECT_TRUE(TaughtWays(maker.map).Shortest(again, 4).empty());
  maker.Link(2, again, true);
  const TaughtWays joined(maker.map);
  EXPECT_EQ(joined.Shortest(again, 4), (std::vector<int>{again, 2, 3, 4}));
  const std::vector<int> around = joined.Shortest(0, 4, {3});
  EXPECT_TRUE(around.empty()) << "the view itself is closed off by 3, and no other pass ends in it";
  const std::vector<int> other = joined.Shortest(0, 16, {3});
  EXPECT_EQ(other, (std::vector<int>{0, 1, 2, again, 15, 16}));
}

TEST(TaughtWays, ALoopThatIsMistrustedOrTurnedIsNoWay) {
  for (const double trust : {0.1, 1.0}) {
    for (const double turned_deg : {0.0, 90.0}) {
      MapMaker maker;  // there and, elsewhere, back again
      maker.Lane(0, 0, 2, 0).View(2, 5, 180).View(0, 5, 0).View(1, 0.2, turned_deg).Link(1, 5, true, trust);
      const bool joined = TaughtWays(maker.map).Shortest(0, 5).size() == 3;
      EXPECT_EQ(joined, trust >= 0.5 && turned_deg <= 30);
    }
  }
}

TEST(TaughtWays, CutsNoCornerByALinkWithinOnePass) {
  MapMaker maker;
  maker.View(0, 0, 0).View(0.3, 0, 20).View(0.5, 0.25, 40).Link(0, 2, true).Link(0, 2);
  EXPECT_EQ(TaughtWays(maker.map).Shortest(0, 2), (std::vector<int>{0, 1, 2}));
}

TEST(TaughtWays, OneSessionIsNoWayOnFromTheOther) {
  MapMaker maker;
  maker.Lane(0, 0, 2, 0).Lane(0.1, 2, 4, 0);  // the second begins where the first ends
  maker.map.sessions = {0, 3};
  EXPECT_TRUE(TaughtWays(maker.map).Shortest(0, 5).empty());
  maker.Link(2, 3, true);
  EXPECT_EQ(TaughtWays(maker.map).Shortest(0, 5), (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

TEST(TaughtWays, TheNearestViewFacesTheSameWay) {
  const TaughtWays ways(MapMaker().View(0, 0, 0).View(0.1, 0, 180).map);
  EXPECT_EQ(ways.Nearest(Vector2d(0.08, 0), 1), 1);
  EXPECT_EQ(ways.Nearest(PlanarPose({0.08, 0}, 0.2), 1), 0);
  EXPECT_EQ(ways.Nearest(Vector2d(5, 0), 1), -1);
  EXPECT_EQ(ways.Nearest(PlanarPose({0, 0}, kRadPerDeg * 90), 1), -1);
}

TEST(TaughtWays, TheFloorFrameIsTheBodysAtTheFirstView) {
  RouteMap map = MapMaker().View(0, 0, 0).View(1, 0, 0).map;  // poses of the camera: z is ahead of it
  Eigen::Matrix3d R_forward;
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  map.X_BC = Pose(R_forward, {0.1, 0.02, 0.6});
  map.graph.nodes[1].X_WC = Pose(Eigen::Quaterniond::Identity(), {-0.5, 0, 2});  // 2 m ahead and 0.5 m to the left
  const TaughtWays ways(map);
  EXPECT_LT(ways.At(0).position.norm(), 1e-12);
  EXPECT_LT((ways.At(1).position - Vector2d(2, 0.5)).norm(), 1e-12);
}

TEST(Route, IsMeasuredAlongAndFoundBesideItself) {
  const Route route({{{0, 0}, 0}, {{2, 0}, 0}, {{4, 0}, 0}});
  EXPECT_DOUBLE_EQ(route.length_m(), 4);
  EXPECT_LT((route.At(3).position - Vector2d(3, 0)).norm(), 1e-12);
  EXPECT_LT((route.At(9).position - Vector2d(4, 0)).norm(), 1e-12);
  EXPECT_NEAR(route.Nearest({2.5, 0.3}, 0, 4), 2.5, 1e-12);
  EXPECT_NEAR(route.Nearest({2.5, 0.3}, 0, 1), 1, 1e-12) << "no farther than asked";
  EXPECT_NEAR(route.DirectionAt(1), 0, 1e-12);
}

TEST(Route, TurnsAcrossHalfATurnWithoutAJump) {
  const Route route({{{0, 0}, kRadPerDeg * 170}, {{-1, 0}, kRadPerDeg * -170}});
  EXPECT_NEAR(route.At(0.5).heading, kRadPerDeg * 180, 1e-9);
}

TEST(Route, CutsNoCornerThatWasDrivenRound) {
  std::vector<PlanarPose> poses;
  constexpr double kRadius_m = 1.5;
  for (double turned = 0; turned < 1.5; turned += 0.15)
    poses.emplace_back(kRadius_m * Vector2d(std::sin(turned), 1 - std::cos(turned)), turned);
  const Route route(poses);
  // Straight lines between views 0.22 m apart pass 4 mm inside the arc.
  for (double s = 0; s < route.length_m(); s += 0.05)
    EXPECT_NEAR((route.At(s).position - Vector2d(0, kRadius_m)).norm(), kRadius_m, 0.006);
}

TEST(Route, RoundsOffAStepAsideBetweenTwoPasses) {
  std::vector<PlanarPose> poses;
  for (int i = 0; i < 20; ++i) poses.emplace_back(Vector2d(0.2 * i, i < 10 ? 0 : 0.1), 0);
  const Route route(poses);
  double steepest = 0;
  for (double s = 0.2; s < route.length_m() - 0.2; s += 0.02)
    steepest = std::max(steepest, std::abs(route.DirectionAt(s)));
  EXPECT_GT(std::atan2(0.1, 0.2), 1.4 * steepest);
  EXPECT_EQ(route.At(0).position, poses.front().position);
  EXPECT_EQ(route.At(route.length_m()).position, poses.back().position);
}

}  // namespace
}  // namespace gaitcam
