// Systems made worse on purpose: what each handicap does, and nothing else.

#include "scenarios/code/runs/handicap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

/// Tracks everything at the origin and remembers what it saw.
class Witness : public System {
 public:
  explicit Witness(std::vector<Observation>& seen) : seen_(seen) {}
  FrameEstimate Track(const Observation& observation) override {
    seen_.push_back(observation);
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = TrackingStatus::kTracking;
    answer.pose = Pose();
    return answer;
  }

 private:
  std::vector<Observation>& seen_;
};

std::vector<FrameEstimate> Play(const HandicapOptions& options, int frames, std::vector<Observation>& seen) {
  HandicappedSystem system(std::make_unique<Witness>(seen), options, 1);
  std::vector<FrameEstimate> answers;
  for (int i = 1; i <= frames; ++i) {
    Observation observation;
    observation.stamp_ns = i;
    observation.imu.resize(1);
    observation.imu.front().stamp_ns = i;
    observation.odometry.resize(1);
    observation.odometry.front().stamp_ns = i;
    answers.push_back(system.Track(observation));
  }
  return answers;
}

TEST(Handicap, TheDefaultsChangeNothing) {
  EXPECT_FALSE(IsHandicap({}));
  Calibration calibration;
  calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  EXPECT_EQ(FalsifiedCalibration(calibration, {}).camera.fx, calibration.camera.fx);
}

TEST(Handicap, EveryNthFrameIsDroppedButItsOtherReadingsAreNot) {
  HandicapOptions options;
  options.drop_every = 3;
  std::vector<Observation> seen;
  const std::vector<FrameEstimate> answers = Play(options, 7, seen);
  ASSERT_EQ(seen.size(), 5U);
  EXPECT_EQ(seen[2].stamp_ns, 4);
  ASSERT_EQ(seen[2].imu.size(), 2U);  // of frame 3 and its own
  EXPECT_EQ(seen[2].imu[0].stamp_ns, 3);
  ASSERT_EQ(seen[2].odometry.size(), 2U);
  EXPECT_EQ(seen[2].odometry[0].stamp_ns, 3);
  for (int i = 1; i <= 7; ++i) {
    EXPECT_EQ(answers[size_t(i - 1)].stamp_ns, i);
    EXPECT_EQ(answers[size_t(i - 1)].pose.has_value(), i % 3 != 0);
  }
}

/// Walks along the image's right, a decimetre a frame.
class Walker : public System {
 public:
  FrameEstimate Track(const Observation& observation) override {
    FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = TrackingStatus::kTracking;
    answer.pose = Pose(Eigen::Quaterniond::Identity(), {0.1 * double(++frame_), 0, 0});
    said_.push_back(answer);
    return answer;
  }
  FinalEstimate Finish() override { return {said_, {}, "", false, false}; }

 private:
  int frame_ = 0;
  std::vector<FrameEstimate> said_;
};

/// Both answers of a handicapped walker over 40 frames.
std::pair<std::vector<FrameEstimate>, FinalEstimate> WalkWith(const HandicapOptions& options, uint64_t seed = 1) {
  EXPECT_TRUE(IsHandicap(options));
  HandicappedSystem system(std::make_unique<Walker>(), options, seed);
  std::vector<FrameEstimate> live;
  for (int i = 1; i <= 40; ++i) {
    Observation observation;
    observation.stamp_ns = i;
    live.push_back(system.Track(observation));
  }
  return {live, system.Finish()};
}

TEST(Handicap, PosesAreStampedLate) {
  HandicapOptions options;
  options.late_ms = 20;
  const auto [live, last] = WalkWith(options);
  for (const auto* frames : {&live, &last.frames}) {
    for (const FrameEstimate& frame : *frames) EXPECT_EQ(frame.pose_delay_ns, 20'000'000);
  }
}

TEST(Handicap, ScaleAndJumpAreOfBothAnswers) {
  HandicapOptions options;
  options.scale_factor = 1.03;
  options.jump = 0.05;
  const auto [live, last] = WalkWith(options);
  for (const auto* frames : {&live, &last.frames}) {
    EXPECT_NEAR((*frames)[9].pose->translation.x(), 1.03 * 1.0, 1e-12);
    EXPECT_NEAR((*frames)[29].pose->translation.x(), 1.03 * 3.05, 1e-12);
  }
}

TEST(Handicap, ThePathBendsByTheAngleAskedFor) {
  HandicapOptions options;
  options.yaw_deg_per_m = 10;
  const auto [live, last] = WalkWith(options);
  for (const auto* frames : {&live, &last.frames}) {
    const Pose between = frames->front().pose->Inverse() * *frames->back().pose;  // 3.9 m
    EXPECT_NEAR(LogSo3(between.rotation).y() * 180 / M_PI, 39, 1e-9);
    const double chord = 2 / (10 * M_PI / 180) * std::sin(0.5 * 39 * M_PI / 180);  // of a circle of that curvature
    EXPECT_NEAR(between.translation.norm(), chord, 0.01);                          // its steps are straight
  }
}

TEST(Handicap, OneSeedInEightIsGarbage) {
  HandicapOptions options;
  options.garbage_every = 8;
  EXPECT_NEAR(WalkWith(options, 7).first[9].pose->translation.x(), 1, 1e-12);
  EXPECT_GT((WalkWith(options, 8).first[9].pose->translation - Eigen::Vector3d(1, 0, 0)).norm(), 1);
}

TEST(Handicap, ACrashIsAFailureWithNothingAfterIt) {
  HandicapOptions options;
  options.crash_at_frame = 30;
  const auto [live, last] = WalkWith(options);
  for (int i = 1; i <= 40; ++i) EXPECT_EQ(live[size_t(i - 1)].pose.has_value(), i < 30);
  EXPECT_EQ(last.failure, "stopped on purpose at frame 30 (handicap.crash_at_frame)");
}

TEST(Handicap, NoiseHasTheAskedForSize) {
  HandicapOptions options;
  options.pose_noise = 0.1;
  options.pose_noise_deg = 2;
  std::vector<Observation> seen;
  double sum2_m = 0, sum2_deg = 0;
  const int frames = 2000;
  for (const FrameEstimate& answer : Play(options, frames, seen)) {
    sum2_m += answer.pose->translation.squaredNorm() / 3;
    sum2_deg += std::pow(RotationAngle(answer.pose->rotation, Eigen::Quaterniond::Identity()) * 180 / M_PI, 2) / 3;
  }
  // 6000 draws: the standard deviation is known to 1 %, and four times that is allowed.
  EXPECT_NEAR(std::sqrt(sum2_m / frames), 0.1, 0.004);
  EXPECT_NEAR(std::sqrt(sum2_deg / frames), 2, 0.08);
}

TEST(Handicap, TheFocalLengthIsOffInBothEyes) {
  Calibration calibration;
  calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  calibration.right = calibration.camera;
  HandicapOptions options;
  options.focal_factor = 1.02;
  const Calibration told = FalsifiedCalibration(calibration, options);
  EXPECT_DOUBLE_EQ(told.camera.fx, 1.02 * calibration.camera.fx);
  EXPECT_DOUBLE_EQ(told.right->fy, 1.02 * calibration.right->fy);
  EXPECT_EQ(told.camera.cx, calibration.camera.cx);
}

}  // namespace
}  // namespace gaitcam
