#include "algorithms/slam/floor_slam.h"

#include <gtest/gtest.h>

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
  std::vector<FrameEstimate> frames;
  FloorPicture floor;
  size_t loops = 0;
};

Walked Walk(const FloorSlamOptions& options, uint64_t seed, int frames) {
  const DrawnFloor floor(11);
  FloorSlam slam(DrawnCalibration(), options, seed);
  for (int i = 0; i < frames; ++i) slam.Track(Observe(Draw(floor, {Round(i)}, 2, uint64_t(i)), i));
  Walked walked;
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
  EXPECT_FALSE(walked.floor.empty());
}

}  // namespace
}  // namespace gaitcam
