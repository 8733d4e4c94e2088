#include "algorithms/slam/floor_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

/// A circle of 1.5 m, and on over what was seen at first; the camera nods a little.
Pose Round(int frame) {
  const double angle = 0.03 * frame, radius_m = 1.5 / (2 * std::numbers::pi);
  const PlanarPose below{{radius_m * std::sin(angle), radius_m * (1 - std::cos(angle))}, angle};
  return CameraOver(below, kDrawnHeight_m, kDrawnPitch_rad + 0.01 * std::sin(0.8 * frame));
}

FloorSlamOptions Options() {
  FloorSlamOptions options;
  options.filter.particles = 30;
  options.filter.loop_m = 1;
  return options;
}

struct Walked {
  std::vector<FrameEstimate> live, frames;
  FloorPicture floor;
  size_t loops = 0;
};

Walked Walk(const FloorSlamOptions& options, uint64_t seed, int frames) {
  const DrawnFloor floor(11);
  FloorSlam slam(DrawnCalibration(), options, seed);
  Walked walked;
  for (int i = 0; i < frames; ++i)
    walked.live.push_back(slam.Track(Observe(Draw(floor, {Round(i)}, 2, uint64_t(i)), i)));
  walked.frames = slam.Finish();
  walked.floor = slam.Floor();
  walked.loops = slam.filter().BestLoops().size();
  return walked;
}

/// The system's world begins below the first camera.
Pose InItsWorld(int frame) { return BelowCamera(Round(0)).Inverse().Lifted() * Round(frame); }

TEST(FloorSlam, WalksRoundAndMapsTheFloorAsItIs) {
  constexpr int kFrames = 225;  // once round is 209
  const Walked walked = Walk(Options(), 1, kFrames);
  ASSERT_EQ(walked.frames.size(), size_t(kFrames));
  double worst_m = 0;
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(walked.frames[size_t(i)].pose) << i;
    worst_m =
        std::max(worst_m, (walked.frames[size_t(i)].pose->translation - InItsWorld(i).translation).head<2>().norm());
  }
  EXPECT_LT(worst_m, 0.02);  // of 1.6 m, at 160 x 120
  EXPECT_GE(walked.loops, 1U);

  const DrawnFloor floor(11);
  const PlanarPose start = BelowCamera(Round(0));
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int row = 0; row < walked.floor.intensity.rows; ++row) {
    for (int column = 0; column < walked.floor.intensity.cols; ++column) {
      if (walked.floor.sightings.at<uint16_t>(row, column) < 2) continue;
      const Eigen::Vector2d p = walked.floor.corner_m + walked.floor.cell_m * Eigen::Vector2d(column, -row);
      const double mapped = walked.floor.intensity.at<uchar>(row, column), truth = floor.At(start * p);
      ++n, a += mapped, b += truth, aa += mapped * mapped, bb += truth * truth, ab += mapped * truth;
    }
  }
  EXPECT_GT(n * walked.floor.cell_m * walked.floor.cell_m, 0.5);  // m^2
  const double correlation = (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
  EXPECT_GT(correlation, 0.95);
}

/// Mean of the normalised squared error over frames, per degree of freedom: 1 is consistent.
double MeanNees(const std::vector<FrameEstimate>& frames) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const Vector6d error = Minus(InItsWorld(int(i)), frames[i].pose.value());
    sum += error.dot(frames[i].covariance.value().ldlt().solve(error)) / 6;
  }
  return sum / double(frames.size());
}

TEST(FloorSlam, SaysHowWellItKnowsItsPose) {
  const Walked walked = Walk(Options(), 1, 120);
  for (const std::vector<FrameEstimate>& frames : {walked.live, walked.frames}) {
    for (const FrameEstimate& frame : frames) {
      ASSERT_TRUE(frame.pose && frame.covariance);
      const Matrix6d& covariance = *frame.covariance;
      EXPECT_LT((covariance - covariance.transpose()).norm(), 1e-12);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(covariance).eigenvalues().minCoeff(), 0);
    }
    const auto variance = [](const FrameEstimate& frame) { return frame.covariance->diagonal().head(3).sum(); };
    EXPECT_GT(variance(frames.back()), variance(frames.front())) << "it grows until a loop is closed";
    // One short walk of an ideal camera: errors of its frames are not independent.
    EXPECT_LT(MeanNees(frames), 3);
    EXPECT_GT(MeanNees(frames), 0.02);
  }
}

TEST(FloorSlam, AfterALossItSaysThatItsWayIsAGuess) {
  const DrawnFloor floor(11);
  FloorSlam slam(DrawnCalibration(), Options(), 1);
  const cv::Mat plain(SmallCamera().height_px, SmallCamera().width_px, CV_8UC1, cv::Scalar(128));
  const auto position_sigma = [](const FrameEstimate& frame) {
    return std::sqrt(frame.covariance.value().topLeftCorner<3, 3>().trace());
  };
  double before_m = 0;
  std::vector<FrameEstimate> after;
  for (int i = 0; i < 110; ++i) {
    const bool blind = i >= 40 && i < 70;
    const FrameEstimate frame = slam.Track(Observe(blind ? plain : Draw(floor, {Round(i)}, 2, uint64_t(i)), i));
    EXPECT_FALSE(blind && frame.pose) << i;
    EXPECT_FALSE(frame.pose && frame.predicted) << i;
    if (i < 40) before_m = position_sigma(frame);
    if (blind) EXPECT_TRUE(frame.predicted) << i;
    if (i >= 70 && frame.pose) after.push_back(frame);
  }
  ASSERT_FALSE(after.empty());
  EXPECT_LT(before_m, 0.02);
  for (const FrameEstimate& frame : after) EXPECT_GT(position_sigma(frame), 0.1) << "a second at walking speed";
}

TEST(FloorSlam, SaysHowWrongItsCalibrationMayMakeIt) {
  const DrawnFloor floor(11);
  Calibration calibration = DrawnCalibration();
  FloorSlam sure(calibration, Options(), 1);
  calibration.standing->height_sigma = 0.1;
  calibration.standing->pitch_sigma = 0.02;
  FloorSlam unsure(calibration, Options(), 1);
  FrameEstimate exact, wrong;
  for (int i = 0; i < 100; ++i) {
    const Observation observation = Observe(Draw(floor, {Round(i)}, 2, uint64_t(i)), i);
    exact = sure.Track(observation);
    wrong = unsure.Track(observation);
  }
  EXPECT_EQ(wrong.pose.value().translation, exact.pose.value().translation) << "the pose is the same";
  const Eigen::Vector3d at = exact.pose->translation;
  const Matrix6d more = *wrong.covariance - *exact.covariance;
  // The scale is that of the height: so much of the way from the start, and of the height; the tilt about two axes.
  EXPECT_NEAR(std::sqrt(more.topLeftCorner<3, 3>().trace()), 0.1 * at.norm(), 0.01 * at.norm());
  EXPECT_NEAR(std::sqrt(more.bottomRightCorner<3, 3>().trace()), 0.02 * std::sqrt(2), 1e-3);
}

TEST(FloorSlam, TheSameSeedGivesTheSameBits) {
  constexpr int kFrames = 40;
  const Walked first = Walk(Options(), 4, kFrames), again = Walk(Options(), 4, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(first.frames[size_t(i)].pose->translation, again.frames[size_t(i)].pose->translation);
    EXPECT_EQ(first.frames[size_t(i)].pose->rotation.coeffs(), again.frames[size_t(i)].pose->rotation.coeffs());
  }
  EXPECT_EQ(cv::norm(first.floor.intensity, again.floor.intensity, cv::NORM_INF), 0);
}

TEST(FloorSlam, WithoutTheMapItTracksAndDrawsButClosesNoLoop) {
  FloorSlamOptions options = Options();
  options.use_map = false;
  const Walked walked = Walk(options, 1, 60);
  EXPECT_EQ(walked.loops, 0U);
  for (const FrameEstimate& frame : walked.frames) EXPECT_FALSE(frame.covariance) << "nothing is known of it";
  EXPECT_FALSE(walked.floor.empty());
}

}  // namespace
}  // namespace gaitcam
