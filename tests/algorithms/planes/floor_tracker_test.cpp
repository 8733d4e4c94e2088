#include "algorithms/planes/floor_tracker.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

/// A walk: 1 cm per frame along a curve, with sway and nod as of small humanoids.
Pose Walking(double frame) {
  const double length_m = 0.01 * frame, turn = 0.4 * length_m, sway = std::sin(0.5 * frame);
  const double lateral_m = 0.006 * sway;
  const PlanarPose below{
      {std::sin(turn) / 0.4 - std::sin(turn) * lateral_m, (1 - std::cos(turn)) / 0.4 + std::cos(turn) * lateral_m},
      turn + 0.01 * sway};
  return CameraOver(below, kDrawnHeight_m + 0.003 * std::sin(frame), kDrawnPitch_rad + 0.012 * std::sin(0.9 * frame),
                    0.02 * sway);
}

constexpr double kGravity_m_s2 = 9.81;

/// The origin of the tracker's world lies below the first camera.
Pose InItsWorld(const Pose& X_WC) { return BelowCamera(Walking(0)).Inverse().Lifted() * X_WC; }

TEST(FloorTrackerStates, OnlyAKeyframeWhoseRegionsProvedToBeFloorIsTrusted) {
  using enum FloorTrackerState;
  using Event = FloorTrackerEvent;
  for (const FloorTrackerState state : {kTracking, kPredicting, kRestarted, kTentative, kTentativePredicting}) {
    EXPECT_EQ(NextState(state, Event::kLost), kRestarted);
    EXPECT_EQ(NextState(state, Event::kNotFloor), kRestarted);
    EXPECT_EQ(NextState(state, Event::kSucceeded), kTracking);
    for (const Event event : {Event::kAligned, Event::kMissed}) {
      EXPECT_EQ(ShowsFloor(NextState(state, event)), ShowsFloor(state)) << int(state) << ", " << int(event);
    }
    EXPECT_EQ(NextState(NextState(state, Event::kMissed), Event::kAligned), NextState(state, Event::kAligned));
  }
  EXPECT_EQ(NextState(kInitializing, Event::kMissed), kInitializing);
  EXPECT_EQ(NextState(kInitializing, Event::kAligned), kTracking);
}

TEST(FloorTracker, FollowsAWalkToHalfAPercentAndKeepsHeightAndTilt) {
  const DrawnFloor floor(1);
  FloorTracker tracker(DrawnCalibration(), {});
  int keyframes = 0;
  FloorTrack last;
  constexpr int kFrames = 60;
  double worst_tilt_deg = 0, worst_height_m = 0;
  for (int i = 0; i < kFrames; ++i) {
    last = tracker.Track(Observe(Draw(floor, {Walking(i)}, 2, uint64_t(i)), i));
    ASSERT_TRUE(last.tracked) << i;
    keyframes += last.retired.has_value();
    const Pose truth = InItsWorld(Walking(i));
    const Eigen::Vector3d up = truth.R() * (last.X_WC.R().transpose() * Eigen::Vector3d::UnitZ());
    worst_tilt_deg = std::max(worst_tilt_deg, std::acos(std::min(1.0, up.z())) * 180 / std::numbers::pi);
    worst_height_m = std::max(worst_height_m, std::abs(last.X_WC.translation.z() - truth.translation.z()));
  }
  const Pose truth = InItsWorld(Walking(kFrames - 1));
  // 0.59 m walked. The first image's tilt is taken for the standing one's; the walk's nod makes it wrong by up to a
  // degree, which changes the distance by 1 % at most.
  EXPECT_LT((last.X_WC.translation - truth.translation).head<2>().norm(), 0.006);
  EXPECT_LT(RotationAngle(last.X_WC.rotation, truth.rotation) * 180 / std::numbers::pi, 1.5);
  EXPECT_LT(worst_tilt_deg, 1.5);
  EXPECT_LT(worst_height_m, 0.02 * kDrawnHeight_m);
  EXPECT_GE(keyframes, 3);
}

TEST(FloorTracker, BlurOfASixteenthOfTheImageDoesNotLoseTheFloor) {
  // 5 cm per frame sideways, two thirds of it during the exposure: 9.5 px of 160 in the middle, 44 cm away.
  const DrawnFloor floor(2);
  const auto at = [](double frame) { return CameraOver({{0, 0.05 * frame}, 0}); };
  FloorTracker tracker(DrawnCalibration(), {});
  FloorTrack last;
  for (int i = 0; i < 10; ++i) {
    std::vector<Pose> exposure;
    for (int s = -7; s <= 7; ++s) exposure.push_back(at(i < 2 ? 0 : i - 1 + s / 15.0 * 2 / 3));
    last = tracker.Track(Observe(Draw(floor, exposure, 1, uint64_t(i)), i, 22.2));
    ASSERT_TRUE(last.tracked) << i;
  }
  EXPECT_NEAR(last.blur_px, 9.5, 0.5);
  EXPECT_NEAR(last.X_WC.translation.y(), 0.4, 0.01);
  EXPECT_NEAR(last.X_WC.translation.x(), 0.0, 0.01);
}

TEST(FloorTracker, WithoutTextureItIsLostAndRecovers) {
  const DrawnFloor floor(3);
  FloorTracker tracker(DrawnCalibration(), {});
  const cv::Mat blank(SmallCamera().height_px, SmallCamera().width_px, CV_8UC1, cv::Scalar(120));
  int frame = 0;
  for (; frame < 10; ++frame) ASSERT_TRUE(tracker.Track(Observe(Draw(floor, {Walking(frame)}, 1), frame)).tracked);
  EXPECT_EQ(tracker.state(), FloorTrackerState::kTracking);
  for (; frame < 25; ++frame) {
    EXPECT_FALSE(tracker.Track(Observe(blank, frame)).tracked) << frame;
    EXPECT_EQ(tracker.state(), frame < 13 ? FloorTrackerState::kPredicting : FloorTrackerState::kRestarted) << frame;
  }
  int aligned = 0, restarted = 0;
  FloorTrack last;
  for (; frame < 50; ++frame) {
    last = tracker.Track(Observe(Draw(floor, {Walking(frame)}, 1), frame));
    aligned += last.tracked || last.tentative;
    restarted += last.restarted;
    EXPECT_FALSE(last.tracked && frame < 30) << "the new keyframe is not known to show floor";
    if (frame == 26) {
      EXPECT_EQ(tracker.state(), FloorTrackerState::kTentative);
    }
  }
  EXPECT_GE(aligned, 23);  // a new keyframe, and from the next frame on
  EXPECT_EQ(restarted, 1);
  EXPECT_TRUE(last.tracked);
}

TEST(FloorTracker, AfterALossTheMotionIsUncertain) {
  const DrawnFloor floor(4);
  FloorTracker tracker(DrawnCalibration(), {});
  const cv::Mat blank(SmallCamera().height_px, SmallCamera().width_px, CV_8UC1, cv::Scalar(120));
  int frame = 0;
  std::vector<FloorKeyframe> keyframes;
  for (; frame < 60; ++frame) {
    const bool hidden = frame >= 15 && frame < 30;
    const FloorTrack track = tracker.Track(Observe(hidden ? blank : Draw(floor, {Walking(frame)}, 1), frame));
    if (track.retired) keyframes.push_back(*track.retired);
  }
  double widest_m = 0, usual_m = 1e9;
  for (size_t k = 1; k < keyframes.size(); ++k) {
    widest_m = std::max(widest_m, std::sqrt(keyframes[k].covariance(0, 0)));
    usual_m = std::min(usual_m, std::sqrt(keyframes[k].covariance(0, 0)));
  }
  EXPECT_LT(usual_m, 0.003);
  EXPECT_GT(widest_m, 0.1);  // half a second at walking speed
}

/// IMU samples of a camera that turns to the left at `rate` rad/s; the IMU has the camera's axes and a bias.
std::vector<ImuSample> ImuOf(const Observation& observation, double rate, const Eigen::Vector3d& bias) {
  std::vector<ImuSample> samples;
  const Eigen::Vector3d up_C = CameraOver({}).R().transpose() * Eigen::Vector3d::UnitZ();
  for (int k = 6; k >= 0; --k) {
    samples.push_back({observation.stamp_ns - k * 5'000'000LL, rate * up_C + bias, kGravity_m_s2 * up_C});
  }
  return samples;
}

TEST(FloorTracker, LearnsTheGyroscopesBiasAndKeepsItsHeadingThroughALoss) {
  const DrawnFloor floor(8);
  Calibration calibration = DrawnCalibration();
  calibration.imu.rate_hz = 200;
  FloorTracker tracker(calibration, {});
  const Eigen::Vector3d bias(0.005, 0.015, -0.01);  // mostly about the vertical: 0.9 degrees per second
  constexpr double kRate_rad_s = 0.3;
  const auto at = [&](int frame) { return CameraOver({{0.01 * frame, 0}, kRate_rad_s * frame / 30.0}); };
  const cv::Mat blank(SmallCamera().height_px, SmallCamera().width_px, CV_8UC1, cv::Scalar(120));
  FloorTrack last;
  constexpr int kSeen = 90, kFrames = 150;
  for (int i = 0; i < kFrames; ++i) {
    Observation observation = Observe(i < kSeen ? Draw(floor, {at(i)}, 1, uint64_t(i)) : blank, i);
    observation.imu = ImuOf(observation, kRate_rad_s, bias);
    last = tracker.Track(observation);
    ASSERT_EQ(last.tracked, i < kSeen) << i;
  }
  const double off_rad = WrapAngle(BelowCamera(last.X_WC).heading - kRate_rad_s * (kFrames - 1) / 30.0);
  // The bias alone would turn it by 1.8 degrees in these 2 s.
  EXPECT_LT(std::abs(off_rad) * 180 / std::numbers::pi, 0.5);
}

/// A frame's, of an IMU in the camera that goes along a walk: 200 Hz, up to the stamp.
/// @param walk the camera's pose by the frame, a real number
std::vector<ImuSample> ImuOfTheWalk(int frame, Pose (*walk)(double) = Walking) {
  constexpr double kFrame_s = 1 / 30.0, kStep_s = 1e-3;
  const auto at = [walk](double t_s) { return walk(t_s / kFrame_s); };
  std::vector<ImuSample> samples;
  for (int k = 6; k >= 0; --k) {
    const double t_s = frame * kFrame_s - k * 5e-3;
    const Pose before = at(t_s - kStep_s), now = at(t_s), after = at(t_s + kStep_s);
    const Eigen::Vector3d acceleration_W =
        (after.translation - 2 * now.translation + before.translation) / (kStep_s * kStep_s);
    samples.push_back({Observe({}, frame).stamp_ns - k * 5'000'000LL,
                       LogSo3(before.rotation.conjugate() * after.rotation) / (2 * kStep_s),
                       now.rotation.conjugate() * (acceleration_W + kGravity_m_s2 * Eigen::Vector3d::UnitZ())});
  }
  return samples;
}

/// Frames of a walk that were aligned, and the error of the last one's position on the floor.
std::pair<int, double> FollowRolling(double readout_s, const FloorTrackerOptions& options = {}) {
  const DrawnFloor floor(12);
  Calibration calibration = DrawnCalibration();
  calibration.imu.rate_hz = 200;
  calibration.readout_ms = 1e3 * readout_s;
  FloorTracker tracker(calibration, options);
  std::pair<int, double> found{0, 0};
  for (int i = 0; i < 60; ++i) {
    Observation observation = Observe(DrawRolling(
                                          floor, [&](double t_s) { return Walking(i + 30 * t_s); }, readout_s),
                                      i);
    observation.imu = ImuOfTheWalk(i);
    const FloorTrack track = tracker.Track(observation);
    found.first += track.tracked;
    found.second = (track.X_WC.translation - InItsWorld(Walking(i)).translation).head<2>().norm();
  }
  return found;
}

TEST(FloorTracker, ARollingShutterIsUndone) {
  constexpr double kReadout_s = 0.02;
  FloorTrackerOptions as_it_rolls;
  as_it_rolls.shutter_by_imu = false;
  const double error_global_m = FollowRolling(0).second;
  const auto [tracked, error_m] = FollowRolling(kReadout_s);
  const auto [tracked_rolling, error_rolling_m] = FollowRolling(kReadout_s, as_it_rolls);
  EXPECT_EQ(tracked, 60);
  EXPECT_LT(error_m, error_global_m + 0.003) << "half a percent of the 0.59 m walked";
  EXPECT_GT(error_rolling_m, 5 * error_m) << "with " << tracked_rolling << " frames tracked";
}

/// A head that nods by 14 degrees, twelve frames long.
Pose Nodding(double frame) {
  return CameraOver({{0.01 * frame, 0}, 0}, kDrawnHeight_m, kDrawnPitch_rad + 0.12 * std::sin(kPi / 6 * frame), 0);
}

TEST(FloorTracker, WhatTheHeadTurnsWhileTheImuIsSilentDoesNotTiltGravity) {
  // While the head goes one way the IMU is silent for a tenth of a second: it would miss 9 degrees of each nod.
  const DrawnFloor floor(13);
  Calibration calibration = DrawnCalibration();
  calibration.imu.rate_hz = 200;
  FloorTracker tracker(calibration, {});
  for (int i = 0; i < 60; ++i) {
    Observation observation = Observe(Draw(floor, {Nodding(i)}, 1, uint64_t(i)), i);
    const bool is_silent = i % 12 >= 5 && i % 12 < 8;
    if (!is_silent) observation.imu = ImuOfTheWalk(i, Nodding);
    EXPECT_TRUE(tracker.Track(observation).tracked) << i;
  }
}

TEST(FloorTracker, ARotationThatTheGyroscopeDoesNotMeasureIsRejected) {
  // The floor itself turns under the standing robot, as only something that is no floor does.
  const DrawnFloor floor(9);
  Calibration calibration = DrawnCalibration();
  calibration.imu.rate_hz = 200;
  FloorTracker tracker(calibration, {});
  int tracked = 0;
  for (int i = 0; i < 60; ++i) {
    const double turned = i < 30 ? 0 : 0.02 * (i - 30);
    Observation observation = Observe(Draw(floor, {CameraOver({{i < 30 ? 0.01 * i : 0.3, 0}, turned})}, 1), i);
    observation.imu = ImuOf(observation, 0, Eigen::Vector3d::Zero());
    const FloorTrack track = tracker.Track(observation);
    if (i < 30) {
      ASSERT_TRUE(track.tracked) << i;
    }
    if (i >= 40) tracked += track.tracked;
  }
  EXPECT_LE(tracked, 4);
}

/// What a tracker made of the regions of a floor that a box stands on.
struct RegionCount {
  int box = 0, box_rejected = 0, floor = 0, floor_rejected = 0;
};

/// A textured box, 25 cm high, 0.55 m ahead, a third of the image at the end.
RegionCount TrackTowardsABox(uint64_t seed) {
  const DrawnFloor floor(seed), side(100 + seed);
  const Obstacle box = [&](const Pose& X_WC, const Eigen::Vector3d& ray) -> std::optional<double> {
    const double distance = (0.55 - X_WC.translation.x()) / ray.x();
    const Eigen::Vector3d p = X_WC.translation + distance * ray;
    if (distance <= 0 || std::abs(p.y()) > 0.15 || p.z() < 0 || p.z() > 0.25) return std::nullopt;
    return side.At({p.y(), p.z()});
  };
  FloorTracker tracker(DrawnCalibration(), {});
  RegionCount count;
  for (int i = 0; i < 45; ++i) {
    const Pose X_WC = CameraOver({{0.005 * i, 0}, 0});
    const FloorTrack track = tracker.Track(Observe(Draw(floor, {X_WC}, 1, uint64_t(i), box), i));
    EXPECT_TRUE(track.tracked) << i;
    if (!track.retired) continue;
    for (const FloorRegion& region : track.retired->regions) {
      if (!region.judged) continue;
      const cv::Point2d middle(region.plane.at.x + 0.5 * region.plane.at.width,
                               region.plane.at.y + 0.5 * region.plane.at.height);
      const Pose& X_WK = track.retired->X_WK;
      const bool on_box = box(X_WK, X_WK.R() * tracker.camera().Unproject({middle.x, middle.y})).has_value();
      ++(on_box ? count.box : count.floor);
      if (!region.is_floor) ++(on_box ? count.box_rejected : count.floor_rejected);
    }
  }
  return count;
}

TEST(FloorTracker, ABoxOnTheFloorIsNoPartOfIt) {
  RegionCount sum;
  for (uint64_t seed = 5; seed < 9; ++seed) {
    const RegionCount count = TrackTowardsABox(seed);
    sum.box += count.box, sum.box_rejected += count.box_rejected;
    sum.floor += count.floor, sum.floor_rejected += count.floor_rejected;
  }
  EXPECT_GT(sum.box, 10);
  EXPECT_GT(sum.floor, 50);
  // Regions at the box's edge hold both. Of 15 on the box a coin rejects 12 in one test of 50.
  EXPECT_GE(sum.box_rejected, 0.75 * sum.box);
  EXPECT_LE(sum.floor_rejected, 0.1 * sum.floor);
}

TEST(FloorTracker, AsksForWhatItNeeds) {
  Calibration calibration = DrawnCalibration();
  calibration.standing.reset();
  EXPECT_THROW(FloorTracker(calibration, {}), BadInput);
  FloorTracker tracker(DrawnCalibration(), {});
  EXPECT_THROW(tracker.Track(Observe(cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)), 0)), BadInput);
}

}  // namespace
}  // namespace gaitcam
