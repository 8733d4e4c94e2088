#include "algorithms/odometry/two_view_vo.h"

#include <gmock/gmock.h>

#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

TwoViewVoOptions WithSift() {
  TwoViewVoOptions options;
  options.feature = "sift";
  return options;
}

// Sideways at 1.8 m/s, 6 cm and 4 px of parallax a frame: what the thesis's steps need, as every frame is a pair.
const Film& FastFilm() {
  static const Film film = FilmPath(
      Room(), kCamera, 20,
      [](double t) {
        return LookingForward({-0.5, -0.8 + 1.8 * t, 0.5}, 0, -0.3, 0);
      },
      2, 2);
  return film;
}

TEST(TwoViewVo, FollowsACameraWhoseFramesHaveABaseline) {
  TwoViewVo vo(kCamera, WithSift(), 1);
  const Estimate estimate = TrackAll(vo, FastFilm().frames);
  EXPECT_EQ(estimate.frames[0].status, TrackingStatus::kInitializing);
  ASSERT_EQ(Count(estimate, TrackingStatus::kTracking), 19);
  for (const FrameEstimate& frame : estimate.frames) EXPECT_FALSE(frame.restarted);
  const double rmse_m = AlignedError(estimate, FastFilm().truth).rmse_m;
  printf("%.4f m\n", rmse_m);
  EXPECT_LT(rmse_m, 0.05) << "on 1.1 m of path";
}

TEST(TwoViewVo, TheFirstBaselineIsTheUnitOfLength) {
  TwoViewVo vo(kCamera, WithSift(), 1);
  const Estimate estimate = TrackAll(vo, FastFilm().frames);
  EXPECT_NEAR(estimate.frames[1].pose->translation.norm(), 1, 1e-9);
  EXPECT_LT(estimate.frames[1].pose->translation.x(), -0.98) << "the camera moves to its left";
}

TEST(TwoViewVo, AFailedPairIsLostAndTheLoopStartsOverAtTheLastPose) {
  std::vector<Observation> frames = FastFilm().frames;
  frames[10] = Filled(frames[10], 0);
  TwoViewVo vo(kCamera, WithSift(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  for (const size_t i : {10u, 11u}) {  // the pairs of frame 10 with 9 and with 11
    EXPECT_FALSE(estimate.frames[i].pose) << i;
    ASSERT_TRUE(estimate.frames[i].predicted) << i;
    EXPECT_EQ(estimate.frames[i].predicted->translation, estimate.frames[9].pose->translation) << i;
  }
  EXPECT_EQ(estimate.frames[10].status, TrackingStatus::kLost);
  EXPECT_EQ(estimate.frames[11].status, TrackingStatus::kInitializing) << "the first pair of another start";
  for (size_t i = 1; i < frames.size(); ++i) EXPECT_EQ(estimate.frames[i].restarted, i == 12) << i;
  ASSERT_TRUE(estimate.frames[9].pose && estimate.frames[12].pose);
  EXPECT_NEAR((estimate.frames[12].pose->translation - estimate.frames[9].pose->translation).norm(), 1, 1e-9)
      << "the unit again";
}

TEST(TwoViewVo, NothingToSeeIsNoPose) {
  TwoViewVo vo(kCamera, WithSift(), 1);
  for (int i = 0; i < 4; ++i) {
    const FrameEstimate answer = vo.Track(Filled(FastFilm().frames[0], i % 2 ? 255 : 0));
    EXPECT_EQ(answer.status, TrackingStatus::kInitializing);
    EXPECT_FALSE(answer.pose);
  }
}

TEST(TwoViewVo, SameSeedSameBits) {
  TwoViewVo a(kCamera, WithSift(), 3), b(kCamera, WithSift(), 3);
  ExpectSameBits(TrackAll(a, FastFilm().frames), TrackAll(b, FastFilm().frames));
}

TEST(TwoViewVo, BadOptionsAndImagesAreRefused) {
  EXPECT_THROW(TwoViewVo(CameraModel(), {}, 1), BadOption);
  TwoViewVoOptions options;
  options.min_points = 4;
  EXPECT_THROW(TwoViewVo(kCamera, options, 1), BadOption) << "five make an essential matrix";
  options = {};
  options.feature = "mobiff";
  EXPECT_THROW(TwoViewVo(kCamera, options, 1), BadOption);
  TwoViewVo vo(kCamera, WithSift(), 1);
  Observation small = FastFilm().frames[0];
  small.image.pixels = cv::Mat::zeros(10, 20, CV_8UC1);
  EXPECT_THROW(vo.Track(small), BadInput);
}

}  // namespace
}  // namespace gaitcam
