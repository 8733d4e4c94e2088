#include "sim/walking/path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/units.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

constexpr double kTolerance = 1e-9;  // m and rad: closed formulas, only rounding

Path Make(PathKind kind, PathDirection direction = PathDirection::kLeft, const Pose& start = {}) {
  PathOptions options;
  options.kind = kind;
  options.direction = direction;
  options.points = {{1, 0}, {1, 2}, {-1, 2}};
  return {options, start};
}

void ExpectPose(const PlanarPose& pose, double x, double y, double heading) {
  EXPECT_NEAR(pose.position.x(), x, kTolerance);
  EXPECT_NEAR(pose.position.y(), y, kTolerance);
  EXPECT_NEAR(pose.heading, heading, kTolerance);
}

TEST(Path, StraightLeadsForwardFromTheStart) {
  const Path path = Make(PathKind::kStraight, PathDirection::kLeft, {RotZ(kPi / 2), Eigen::Vector3d(1, 2, 0.3)});
  EXPECT_DOUBLE_EQ(path.Length(), 5);
  ExpectPose(path.PoseAt(2), 1, 4, kPi / 2);
  ExpectPose(path.goal(), 1, 7, kPi / 2);
}

TEST(Path, CircleClosesAfterOneTurnToEitherSide) {
  for (const double sense : {1.0, -1.0}) {
    const Path path = Make(PathKind::kCircle, sense > 0 ? PathDirection::kLeft : PathDirection::kRight);
    EXPECT_NEAR(path.Length(), 4 * kPi, kTolerance);
    ExpectPose(path.goal(), 0, 0, sense * 2 * kPi);
    ExpectPose(path.PoseAt(kPi), 2, sense * 2, sense * kPi / 2);  // a quarter of it
  }
}

TEST(Path, SquareReturnsToItsStartWithTheStartsHeading) {
  const Path path = Make(PathKind::kSquare, PathDirection::kRight);
  EXPECT_DOUBLE_EQ(path.Length(), 8);
  EXPECT_NEAR(path.TotalTurn(), 2 * kPi, kTolerance);
  ExpectPose(path.goal(), 0, 0, -2 * kPi);
  ExpectPose(path.PoseAt(3), 2, -1, -kPi / 2);
}

TEST(Path, ThereAndBackTurnsOnTheSpot) {
  const Path path = Make(PathKind::kThereAndBack);
  ASSERT_EQ(path.segments().size(), 3u);
  EXPECT_TRUE(path.segments()[1].IsTurnOnTheSpot());
  ExpectPose(path.goal(), 0, 0, kPi);
}

TEST(Path, PolylineVisitsItsPointsInTheStartFrame) {
  const Path path = Make(PathKind::kPolyline, PathDirection::kLeft, {RotZ(kPi / 2), Eigen::Vector3d(0, 0, 0)});
  ExpectPose(path.PoseAt(1), 0, 1, kPi / 2);
  ExpectPose(path.PoseAt(3), -2, 1, kPi);
  ExpectPose(path.goal(), -2, -1, 3 * kPi / 2);
}

TEST(Path, DrivingTakesTimeForTheWayAndForTheTurns) {
  const Path path = Make(PathKind::kThereAndBack);
  EXPECT_NEAR(path.Duration(0.5, 1.0), 20 + kPi, kTolerance);
  ExpectPose(path.PoseAtTime(4, 0.5, 1.0), 2, 0, 0);
  ExpectPose(path.PoseAtTime(11, 0.5, 1.0), 5, 0, 1);
  ExpectPose(path.PoseAtTime(1e9, 0.5, 1.0), 0, 0, kPi);
}

TEST(PathSegment, LocatesPointsBesideLinesAndArcs) {
  for (const double turn : {0.0, 3.0, -3.0, 7.0}) {
    const PathSegment segment{{{0.3, -0.2}, 0.7}, 2.0, turn};
    for (const double along : {0.1, 1.0, 1.9, 2.1}) {
      for (const double left : {-0.1, 0.0, 0.2}) {
        const Eigen::Vector2d p = segment.At(along) * Eigen::Vector2d(0, left);
        const PathSegment::Location found = segment.Locate(p, along + 0.1);
        EXPECT_NEAR(found.along, along, kTolerance) << "turn " << turn;
        EXPECT_NEAR(found.left, left, kTolerance) << "turn " << turn;
      }
    }
  }
}

TEST(Path, DistanceIsZeroOnThePathAndGrowsBesideIt) {
  const Path circle = Make(PathKind::kCircle);
  EXPECT_NEAR(circle.DistanceTo({0, 4}), 0, kTolerance);
  EXPECT_NEAR(circle.DistanceTo({0, 2.5}), 1.5, kTolerance);
  EXPECT_NEAR(Make(PathKind::kStraight).DistanceTo({6, 0}), 1, kTolerance);
  EXPECT_NEAR(Make(PathKind::kStand).DistanceTo({3, 4}), 5, kTolerance);
}

TEST(Path, RefusesAPolylineThatLeadsNowhere) {
  PathOptions options;
  options.kind = PathKind::kPolyline;
  EXPECT_THROW(Path(options, {}), BadOption);
  options.points = {{1, 0}, {1, 0}};
  EXPECT_THROW(Path(options, {}), BadOption);
}

TEST(Path, RoundedCornersAreArcsThatTouchBothLegs) {
  PathOptions options;
  options.kind = PathKind::kPolyline;
  options.points = {{10, 0}, {10, 5}, {0, 5}};
  options.corner_radius_m = 2;
  const Path path(options, {RotZ(0.3), Eigen::Vector3d(1, 2, 0)});
  EXPECT_NEAR(path.Length(), 25 - 2 * 2 * (2 - kPi / 2), kTolerance);
  EXPECT_LT((path.goal().position - path.start() * Eigen::Vector2d(0, 5)).norm(), kTolerance);
  PlanarPose before = path.start();
  for (double s = 0.01; s < path.Length(); s += 0.01) {  // no turn on the spot, nor a jump
    const PlanarPose here = path.PoseAt(s);
    EXPECT_LT((here.position - before.position).norm(), 0.0101);
    EXPECT_LT(std::abs(here.heading - before.heading), 0.0101 / 2);
    before = here;
  }
  for (const PathSegment& segment : path.segments()) EXPECT_FALSE(segment.IsTurnOnTheSpot());
}

TEST(Path, RefusesCornersThatItsLegsAreTooShortFor) {
  PathOptions options;
  options.kind = PathKind::kPolyline;
  options.points = {{3, 0}, {3, 3}, {0, 3}};
  options.corner_radius_m = 1.6;  // the leg between has room for 1.5
  EXPECT_THAT(ErrorOf([&] { Path(options, {}); }), testing::HasSubstr("path.corner_radius_m: 1.6"));
  options.corner_radius_m = 1.4;
  EXPECT_NEAR(Path(options, {}).goal().heading, kPi, kTolerance);
  options.corner_radius_m = 0;
  EXPECT_THAT(ErrorOf([&] { Path(options, {}); }), testing::HasSubstr("expected a length above 0"));
}

TEST(Path, RefusesAnUnknownKind) {
  PathOptions options;
  options.kind = PathKind(17);
  EXPECT_THROW(Path(options, {}), BadOption);
}

}  // namespace
}  // namespace gaitcam
