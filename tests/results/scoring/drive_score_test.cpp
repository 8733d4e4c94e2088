#include "results/scoring/drive_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr int64_t kStep_ns = 250'000'000;

/// A camera that stands where its body does, every quarter of a second.
Trajectory DrivenPath(const std::function<Vector2d(double time_s)>& at, double duration_s) {
  Trajectory path;
  for (int64_t t = 0; 1e-9 * double(t) <= duration_s + 1e-9; t += kStep_ns) {
    const Vector2d p = at(1e-9 * double(t));
    path.push_back({t, {Eigen::Quaterniond(1, 0, 0, 0), {p.x(), p.y(), 0}}});
  }
  return path;
}

Trajectory TaughtAlongX() {
  return DrivenPath([](double t) { return Vector2d(0.5 * t, 0); }, 20);
}

/// Says that it drove at every frame and arrived at the last, by a route from `from_s` to `to_s` of the taught walk.
TaughtDrive Said(const Trajectory& driven, double from_s, double to_s) {
  TaughtDrive drive;
  DriveRoute route;
  for (int64_t t = int64_t(1e9 * from_s); t <= int64_t(1e9 * to_s); t += 4 * kStep_ns) route.views_ns.push_back(t);
  drive.routes.push_back(route);
  for (const StampedPose& pose : driven) drive.steps.push_back({pose.stamp_ns, DriveState::kDriving, true, false, {}});
  drive.steps.back().state = DriveState::kArrived;
  return drive;
}

std::vector<Vector2d> Nobody(int64_t) { return {}; }

double ScoreOf(const DriveComparison& comparison, const std::string& name) {
  for (const Score& score : comparison.scores) {
    if (score.name == "drive_" + name) return score.value;
  }
  ADD_FAILURE() << name;
  return 0;
}

TEST(DriveScore, DeviationIsTheTrueDistanceFromTheTaughtWay) {
  const Trajectory taught = TaughtAlongX();
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(2 + 0.3 * t, t < 10 ? 0.02 : -0.06); }, 20);
  const DriveComparison comparison = CompareDrive(Said(driven, 4, 16), {driven, taught, Nobody});
  // Of 80 steps 39 end at 2 cm and 41 at 6 cm; the one between them moves.
  EXPECT_NEAR(ScoreOf(comparison, "deviation_mean_m"), (39 * 0.02 + 41 * 0.06) / 80, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "deviation_max_m"), 0.06, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "goal_error_m"), 0.06, 1e-9);
  EXPECT_EQ(ScoreOf(comparison, "goal_reached"), 1);
  EXPECT_NEAR(ScoreOf(comparison, "speed_mps"), 0.3, 0.002);
  EXPECT_NEAR(ScoreOf(comparison, "time_s"), 20, 1e-9);
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "clearance_m")));
}

TEST(DriveScore, TheWholeWalkBetweenTwoViewsWasTaughtNotTheirStraightLine) {
  const auto bow = [](double t) { return Vector2d(0.5 * t, 0.3 * std::sin(0.5 * t)); };
  const Trajectory taught = DrivenPath(bow, 20), driven = DrivenPath(bow, 20);
  TaughtDrive drive = Said(driven, 0, 20);
  drive.routes[0].views_ns = {0, int64_t(20e9)};
  const DriveComparison comparison = CompareDrive(drive, {driven, taught, Nobody});
  EXPECT_LT(ScoreOf(comparison, "deviation_max_m"), 1e-9);
  EXPECT_NEAR(comparison.taught_m[0].size(), taught.size(), 1);
}

TEST(DriveScore, StandingStillIsNoDeviation) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(2 + 0.3 * std::min(t, 5.0), 0.05); }, 20);
  const DriveComparison comparison = CompareDrive(Said(driven, 4, 7), {driven, TaughtAlongX(), Nobody});
  EXPECT_NEAR(ScoreOf(comparison, "deviation_mean_m"), 0.05, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "speed_mps"), 0.3 * 5 / 20, 0.005);
}

TEST(DriveScore, OnlyWhoStandsAtTheGoalAndSaysSoHasReachedIt) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(2 + 0.3 * t, 0); }, 20);  // ends at 8 m
  const auto reached = [&](double to_s, DriveState last) {
    TaughtDrive drive = Said(driven, 4, to_s);
    drive.steps.back().state = last;
    return ScoreOf(CompareDrive(drive, {driven, TaughtAlongX(), Nobody}), "goal_reached");
  };
  EXPECT_EQ(reached(16, DriveState::kArrived), 1);  // at 8 m
  EXPECT_EQ(reached(16, DriveState::kDriving), 0);
  EXPECT_EQ(reached(18, DriveState::kArrived), 0);  // at 9 m
}

TEST(DriveScore, WithoutTheTaughtWalksTruthOnlyWhatNeedsItIsUnknown) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(2 + 0.3 * t, 0); }, 20), unknown;
  const DriveComparison comparison = CompareDrive(Said(driven, 4, 16), {driven, unknown, Nobody});
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "deviation_mean_m")));
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "goal_error_m")));
  EXPECT_EQ(ScoreOf(comparison, "goal_reached"), 0);
  EXPECT_NEAR(ScoreOf(comparison, "time_s"), 20, 1e-9);
}

TEST(DriveScore, WhoWalksIntoAStandingRobotIsNotTouchedByIt) {
  const Trajectory standing = DrivenPath([](double) { return Vector2d(5, 0); }, 10);
  const auto comes = [](int64_t t) { return std::vector<Vector2d>{{1 + 1e-9 * double(t), 0}}; };  // there at 4 s
  const DriveComparison comparison = CompareDrive(Said(standing, 4, 10), {standing, TaughtAlongX(), comes});
  EXPECT_EQ(ScoreOf(comparison, "touches"), 0);
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "clearance_m")));
  EXPECT_NEAR(ScoreOf(comparison, "nearest_person_m"), -0.47, 0.06);
}

TEST(DriveScore, EachPersonThatTheRobotDrivesIntoIsTouchedOnce) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(0.3 * t, 0); }, 20);
  const auto stand = [](int64_t) {
    return std::vector<Vector2d>{{2, 0.3}, {4, -0.46}, {5, 0.5}, {-0.2, 0}};  // the last one stands behind it
  };
  const DriveComparison comparison = CompareDrive(Said(driven, 0, 12), {driven, TaughtAlongX(), stand});
  EXPECT_EQ(ScoreOf(comparison, "touches"), 2);
  EXPECT_NEAR(ScoreOf(comparison, "clearance_m"), 0.3 - 0.47, 0.001);
  EXPECT_EQ(comparison.people_m.size(), 4u);
}

TEST(DriveScore, WhoWasCarriedOffIsFoundOnceAViewTellsWhereItTrulyIs) {
  // Driven for 8 s, carried back by 2 m within 2 s, driven on; for 5 s more it believes that it never was carried.
  const auto at = [](double t) { return Vector2d(0.3 * t - 1.3 * std::clamp(t - 8, 0.0, 2.0), 0.01); };
  const Trajectory driven = DrivenPath(at, 20);
  TaughtDrive drive = Said(driven, 0, 12);
  for (DriveStep& step : drive.steps) {
    const double t = 1e-9 * double(step.stamp_ns);
    const bool mistaken = t > 8 && t < 15;
    step.confirmed = !mistaken || t > 13;  // what a view confirms may be wrong
    step.X_FB = {mistaken ? Vector2d(0.3 * t, 0) : at(t), 0};
  }
  DriveTruth truth{driven, TaughtAlongX(), Nobody, CarriedSpan{int64_t(8e9), int64_t(10e9)}};
  const DriveComparison comparison = CompareDrive(drive, truth);
  EXPECT_NEAR(ScoreOf(comparison, "refound_s"), 5, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "mistaken_m"), 5 * 0.3, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "misplaced_s"), 1.75, 1e-9) << "confirmed and mistaken: after 13 s and before 15 s";
  TaughtDrive stands = drive;
  for (DriveStep& step : stands.steps) step.state = DriveState::kSearching;
  EXPECT_NEAR(ScoreOf(CompareDrive(stands, truth), "misplaced_s"), 1.75, 1e-9) << "who stands may be mistaken, too";
  EXPECT_NEAR(ScoreOf(comparison, "speed_mps"), 0.3, 1e-9) << "nor is the way in the air driven";
  drive.steps.resize(56);  // until 14 s
  EXPECT_TRUE(std::isnan(ScoreOf(CompareDrive(drive, truth), "refound_s")));
  truth.carried.reset();
  EXPECT_TRUE(std::isnan(ScoreOf(CompareDrive(drive, truth), "mistaken_m")));
}

TEST(DriveScore, WhoeverIsCarriedOverSomebodyDoesNotDriveIntoHim) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(0.3 * t, 0); }, 20);
  const auto stands = [](int64_t) { return std::vector<Vector2d>{{3, 0}}; };
  const DriveTruth truth{driven, TaughtAlongX(), stands, CarriedSpan{int64_t(8e9), int64_t(12e9)}};
  const DriveComparison comparison = CompareDrive(Said(driven, 0, 12), truth);
  EXPECT_EQ(ScoreOf(comparison, "touches"), 0);
  EXPECT_NEAR(ScoreOf(comparison, "clearance_m"), 3 - 0.3 * 8 - 0.47, 0.02);
  EXPECT_NEAR(ScoreOf(comparison, "nearest_person_m"), -0.47, 0.02);
}

TEST(DriveScore, WhoComesFasterThanTheRobotComesByHisOwnMotion) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(0.3 * t, 0); }, 10);
  const auto overtakes = [](double mps) {
    return [mps](int64_t t) { return std::vector<Vector2d>{{4 - mps * 1e-9 * double(t), 0.6}}; };
  };
  const DriveComparison fast = CompareDrive(Said(driven, 0, 6), {driven, TaughtAlongX(), overtakes(1.2)});
  EXPECT_TRUE(std::isnan(ScoreOf(fast, "clearance_m")));
  EXPECT_NEAR(ScoreOf(fast, "clearance_moving_m"), 0.6 - 0.47, 0.01);
  const DriveComparison slow = CompareDrive(Said(driven, 0, 6), {driven, TaughtAlongX(), overtakes(0.2)});
  EXPECT_NEAR(ScoreOf(slow, "clearance_m"), 0.6 - 0.47, 0.01);
}

TEST(DriveScore, WhoStandsBesideTheCamerasViewCouldNotBeSeen) {
  // The camera looks along +x: its z axis is the way ahead.
  Eigen::Matrix3d R_forward;
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Trajectory driven = DrivenPath([](double t) { return Vector2d(0.3 * t, 0); }, 20);
  for (StampedPose& pose : driven) pose.pose.rotation = Eigen::Quaterniond(R_forward);
  TaughtDrive drive = Said(driven, 0, 12);
  drive.half_view_rad = 0.5;
  const auto stand = [](int64_t) { return std::vector<Vector2d>{{2, 0.4}}; };
  const DriveComparison comparison = CompareDrive(drive, {driven, TaughtAlongX(), stand});
  EXPECT_EQ(ScoreOf(comparison, "touches"), 1);
  EXPECT_EQ(ScoreOf(comparison, "touches_in_view"), 0);
  EXPECT_NEAR(ScoreOf(comparison, "clearance_m"), 0.4 - 0.47, 0.001);
  // It leaves the view where 0.4 m are at 0.5 rad.
  EXPECT_NEAR(ScoreOf(comparison, "clearance_in_view_m"), 0.4 / std::sin(0.5) - 0.47, 0.02);
}

TEST(DriveScore, ADeviationAtTheStartIsToldApart) {
  const Trajectory driven = DrivenPath([](double t) { return Vector2d(2 + 0.3 * t, t < 2 ? 0.1 : 0.01); }, 20);
  const DriveComparison comparison = CompareDrive(Said(driven, 4, 16), {driven, TaughtAlongX(), Nobody});
  EXPECT_NEAR(ScoreOf(comparison, "deviation_max_m"), 0.1, 1e-9);
  EXPECT_NEAR(ScoreOf(comparison, "deviation_way_max_m"), 0.01, 1e-9);
}

TEST(DriveScore, NothingIsSaidOfADriveThatNeverBegan) {
  const Trajectory driven = DrivenPath([](double) { return Vector2d(5, 0); }, 10);
  TaughtDrive drive = Said(driven, 4, 10);
  drive.routes.clear();
  for (DriveStep& step : drive.steps) step.state = DriveState::kSearching;
  const DriveComparison comparison = CompareDrive(drive, {driven, TaughtAlongX(), Nobody});
  EXPECT_EQ(ScoreOf(comparison, "goal_reached"), 0);
  EXPECT_NEAR(ScoreOf(comparison, "searched_s"), 10, 1e-9);
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "deviation_mean_m")));
  EXPECT_TRUE(std::isnan(ScoreOf(CompareDrive({}, {driven, driven, Nobody}), "time_s")));
}

}  // namespace
}  // namespace gaitcam
