// Systems made worse on purpose: what each handicap does, and nothing else.

#include "scenarios/code/runs/handicap.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(Handicap, EveryNthFrameIsDroppedButItsInertialReadingsAreNot) {
  HandicapOptions options;
  options.drop_every = 3;
  std::vector<Observation> seen;
  const std::vector<FrameEstimate> answers = Play(options, 7, seen);
  ASSERT_EQ(seen.size(), 5U);
  EXPECT_EQ(seen[2].stamp_ns, 4);
  ASSERT_EQ(seen[2].imu.size(), 2U);  // of frame 3 and its own
  EXPECT_EQ(seen[2].imu[0].stamp_ns, 3);
  for (int i = 1; i <= 7; ++i) {
    EXPECT_EQ(answers[size_t(i - 1)].stamp_ns, i);
    EXPECT_EQ(answers[size_t(i - 1)].pose.has_value(), i % 3 != 0);
  }
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
