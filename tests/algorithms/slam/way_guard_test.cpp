#include "algorithms/slam/way_guard.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/units.h"
#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr int64_t kSecond_ns = 1'000'000'000;

/// A camera 0.5 m over the floor that looks straight ahead, over the body's middle.
Calibration Ahead() {
  Calibration calibration = OneCamera();
  calibration.odometry.X_BC = LookingForward({0, 0, 0.5}, 0, 0, 0);
  return calibration;
}

/// Of that camera where the body is there.
Pose From(const PlanarPose& X_FB) { return X_FB.Lifted() * Ahead().odometry.X_BC; }

/// A wall across the whole view at this distance; 0: nothing was measured.
cv::Mat Wall(double z_m) { return cv::Mat(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(z_m)); }

/// Metres straight on from a body at the origin.
double FreeAhead(const WayGuard& guard) {
  return guard.FreeWay([](double along_m) { return Vector2d(along_m, 0); });
}

TEST(WayGuard, StopsShortOfAWallByItsClearance) {
  for (const double wall_m : {0.8, 1.2, 2.0}) {
    WayGuard guard(Ahead(), {});
    guard.See(0, From({}), Wall(wall_m));
    // 0.22 m of body and 0.3 m of clearance; looked at every 0.1 m, and one step is kept in hand.
    EXPECT_LE(FreeAhead(guard), wall_m - 0.52);
    EXPECT_GT(FreeAhead(guard), wall_m - 0.52 - 0.25);
  }
}

TEST(WayGuard, WhatIsBesideTheWayIsNotInIt) {
  WayGuard guard(Ahead(), {});
  cv::Mat depth = Wall(5);
  depth.colRange(0, kCamera.width_px / 8).setTo(1.5);  // at 1.5 m, 0.65 m or more to the left
  guard.See(0, From({}), depth);
  EXPECT_EQ(FreeAhead(guard), WayGuardOptions().look_m);
  EXPECT_LT(guard.FreeWay([](double along_m) { return Vector2d(along_m, 0.5 * along_m); }), 1.5);
}

TEST(WayGuard, TheFloorAndAFewStrayPointsAreNothing) {
  WayGuard guard(Ahead(), {});
  cv::Mat depth = Wall(5);
  for (int row = kCamera.height_px / 2 + 1; row < depth.rows; ++row)
    depth.row(row).setTo(std::min(5.0, 0.5 * kCamera.fy / (row - kCamera.cy)));
  depth(cv::Rect(kCamera.width_px / 2, 60, 16, 16)).setTo(0.8);  // four of the pixels that are looked at
  guard.See(0, From({}), depth);
  EXPECT_EQ(FreeAhead(guard), WayGuardOptions().look_m);
}

TEST(WayGuard, ATiltedHeadTakesTheFloorForNothing) {
  // It nods by 10 degrees over a bare floor: taken as level, the floor 1.5 m ahead would stand 0.26 m high.
  WayGuard guard(Ahead(), {});
  const Pose X_FC = LookingForward({0, 0, 0.5}, 0, 0, 0) * Pose(RotX(-10 * kRadPerDeg), {0, 0, 0});
  cv::Mat depth = Wall(0);
  for (int row = 0; row < depth.rows; ++row) {
    for (int column = 0; column < depth.cols; ++column) {
      const double down = (X_FC.R() * kCamera.Unproject({double(column), double(row)})).z();
      const double z = down < 0 ? -0.5 / down : 0;
      if (z < 5) depth.at<float>(row, column) = float(z);
    }
  }
  guard.See(0, X_FC, depth);
  EXPECT_EQ(FreeAhead(guard), WayGuardOptions().look_m);
  WayGuard mistaken(Ahead(), {});
  mistaken.See(0, From({}), depth);
  EXPECT_LT(FreeAhead(mistaken), WayGuardOptions().look_m);
}

TEST(WayGuard, BelievesInWhatItNoLongerSeesForAWhile) {
  WayGuard guard(Ahead(), {});
  guard.See(0, From({}), Wall(0.7));
  guard.See(kSecond_ns, From({}), Wall(0));  // too near to be measured
  EXPECT_LT(FreeAhead(guard), 0.2);
  WayGuard later = guard;
  later.See(7 * kSecond_ns, From({}), Wall(0));
  EXPECT_EQ(FreeAhead(later), WayGuardOptions().look_m);
  guard.See(2 * kSecond_ns, From({}), Wall(4));  // somebody went away: the wall behind him is seen
  EXPECT_EQ(FreeAhead(guard), WayGuardOptions().look_m);
}

TEST(WayGuard, WhoHasMovedIsGivenTheRoomToComeOn) {
  constexpr double kBrake_mps2 = 0.25, kReaction_s = 0.25;
  const auto speed = [&](double person_m, double going_m = 0) {
    WayGuard guard(Ahead(), {});
    guard.See(0, From({}), Wall(4));
    cv::Mat depth = Wall(4);
    depth.colRange(100, 140).setTo(person_m);
    guard.See(kSecond_ns / 4, From({}), depth);
    return guard.SpeedAmongWalkers({kBrake_mps2, kReaction_s, going_m});
  };
  double slower = 0;
  for (const double person_m : {0.8, 1.2, 2.0, 3.0}) {
    const double v = speed(person_m);
    EXPECT_GE(v, slower) << "the farther away, the faster";
    // While the robot brakes, both come towards each other until they are apart by the clearance.
    const double met_m = v * v / (2 * kBrake_mps2) + 1.4 * (kReaction_s + v / kBrake_mps2);
    if (v > 0) {
      EXPECT_NEAR(met_m, person_m - 0.22 - 0.3, 0.05);
    }
    slower = v;
  }
  EXPECT_EQ(speed(0.8), 0);
  // What the robot goes by earlier commands is as if the person were nearer by that.
  EXPECT_NEAR(speed(3, 0.5), speed(2.5), 1e-3);
}

TEST(WayGuard, WhatStandsDoesNotMoveBecauseTheRobotDoes) {
  WayGuard guard(Ahead(), {});
  cv::Mat depth = Wall(4);
  depth.colRange(100, 140).setTo(2.0);
  guard.See(0, From({}), depth);
  depth = Wall(3.9);
  depth.colRange(99, 141).setTo(1.9);
  guard.See(kSecond_ns / 4, From({{0.1, 0}, 0}), depth);
  EXPECT_GT(guard.SpeedAmongWalkers({0.25, 0.25, 0}), 100);
}

TEST(WayGuard, AnEdgeDoesNotMoveBecauseTheHeadRocks) {
  const auto is_moving = [](double pose_error_deg, int from_px, int to_px) {
    WayGuardOptions options;
    options.pose_error_deg = pose_error_deg;
    WayGuard guard(Ahead(), options);
    cv::Mat depth = Wall(4);
    depth.colRange(100, 140).setTo(2.0);
    guard.See(0, From({}), depth);
    depth = Wall(4);
    depth.colRange(from_px, to_px).setTo(2.0);
    guard.See(kSecond_ns / 4, From({}), depth);
    return guard.SpeedAmongWalkers({0.25, 0.25, 0}) < 100;
  };
  const int rocked_px = int(kCamera.fx * std::tan(1 * kRadPerDeg));  // rounded down
  ASSERT_GE(rocked_px, 2);
  EXPECT_TRUE(is_moving(0, 100 + rocked_px, 140 + rocked_px));
  EXPECT_FALSE(is_moving(1, 100 + rocked_px, 140 + rocked_px));
  EXPECT_FALSE(is_moving(1, 100 - rocked_px, 140 - rocked_px));
  EXPECT_TRUE(is_moving(1, 125, 165)) << "a step aside";
  EXPECT_TRUE(is_moving(1, 180, 200)) << "somebody who was not there";
}

TEST(WayGuard, KnowsWhatStandsWhereItDoesNotLook) {
  WayGuard guard(Ahead(), {});
  guard.See(0, From({}), Wall(1));
  guard.See(kSecond_ns, From({{0, 0}, 3.1}), Wall(4));  // turned about: the wall is behind it now
  EXPECT_LT(FreeAhead(guard), 0.5);
  guard.Forget();
  guard.See(kSecond_ns, From({{0, 0}, 3.1}), Wall(4));
  EXPECT_EQ(FreeAhead(guard), WayGuardOptions().look_m);
}

}  // namespace
}  // namespace gaitcam
