#include "algorithms/odometry/mobif_vo_plus.h"

#include <gmock/gmock.h>

#include <thread>

#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

MobifVoPlusOptions Fast() {
  MobifVoPlusOptions options;
  options.feature = "sift";
  options.max_features = 400;
  return options;
}

// Half the speed of the other film's 40 frames, and twice as long.
const Film& LongFilm() {
  static const Film film = FilmPath(Room(), kCamera, 60, SidewaysPose, 5, 2);
  return film;
}

TEST(MobifVoPlus, FollowsASidewaysMotionFromTheFirstFrameOn) {
  MobifVoPlus vo(OneCamera(), Fast(), 1);
  const Estimate live = TrackAll(vo, LongFilm().frames);
  ExpectSane(live);
  EXPECT_EQ(Count(live, TrackingStatus::kTracking), 60) << "before there is a map it takes the motion for a turn";
  Estimate final_word;
  final_word.frames = vo.Finish();
  ASSERT_EQ(final_word.frames.size(), live.frames.size());
  EXPECT_LT(AlignedError(final_word, LongFilm().truth).rmse_m,
            0.01);  // 2 % of 0.5 m, the frames before the map included
}

TEST(MobifVoPlus, ATurnOnTheSpotIsFollowedWithoutAMap) {
  const auto turn = [](double t) { return LookingForward({-0.5, 0, 0.4}, 0.3 * t, -0.2, 0.05 * std::sin(5 * t)); };
  const Film film = FilmPath(Room(), kCamera, 25, turn, 10, 2);
  MobifVoPlus vo(OneCamera(), Fast(), 1);
  const Estimate estimate = TrackAll(vo, film.frames);
  ASSERT_EQ(Count(estimate, TrackingStatus::kTracking), 25);
  const Pose first = PoseAt(film.truth, estimate.frames[0].stamp_ns).value();
  for (const FrameEstimate& frame : estimate.frames) {
    const Pose moved = first.Inverse() * *PoseAt(film.truth, frame.stamp_ns);
    EXPECT_LT(RotationAngle(frame.pose->rotation, moved.rotation), 0.004);  // a pixel is 0.005 rad
    EXPECT_LT(frame.pose->translation.norm(), 0.01) << "nothing was seen to move";
  }
}

TEST(MobifVoPlus, SameBitsWhateverTheThreads) {
  const std::vector<Observation>& frames = SidewaysFilm().frames;
  MobifVoPlus vo(OneCamera(), Fast(), 3);
  const Estimate expected = TrackAll(vo, frames);
  Estimate other;
  const int threads = cv::getNumThreads();
  std::thread([&] {
    cv::setNumThreads(1);
    cv::theRNG().state = 0x1234567;
    MobifVoPlus again(OneCamera(), Fast(), 3);
    for (const Observation& frame : frames) other.frames.push_back(again.Track(frame));
  }).join();
  cv::setNumThreads(threads);
  ExpectSameBits(expected, other);
}

class PlusMishap : public testing::TestWithParam<Mishap> {};

TEST_P(PlusMishap, IsSurvivedAndThePathFoundAgain) {
  std::vector<Observation> frames = SidewaysFilm().frames;
  for (size_t i = 27; i < 32; ++i) frames[i] = GetParam().befalls(frames[i]);
  MobifVoPlus vo(OneCamera(), Fast(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  ExpectSane(estimate);
  for (const FrameEstimate& frame : estimate.frames) EXPECT_FALSE(frame.restarted);
  for (size_t i = 32; i < frames.size(); ++i) EXPECT_EQ(estimate.frames[i].status, TrackingStatus::kTracking) << i;
}

INSTANTIATE_TEST_SUITE_P(, PlusMishap, testing::ValuesIn(Mishaps()), [](const auto& info) { return info.param.name; });

TEST(MobifVoPlus, APathThatStaysLostIsBegunAnewAndMarked) {
  MobifVoPlusOptions options = Fast();
  options.max_lost_frames = 2;
  std::vector<Observation> frames = SidewaysFilm().frames;
  frames.insert(frames.begin() + 30, 5, Filled(frames[0], 0));
  MobifVoPlus vo(OneCamera(), options, 1);
  const Estimate estimate = TrackAll(vo, frames);
  ExpectSane(estimate);
  int restarts = 0;
  for (const FrameEstimate& frame : estimate.frames) restarts += frame.restarted;
  EXPECT_EQ(restarts, 1);
  EXPECT_EQ(estimate.frames.back().status, TrackingStatus::kTracking);
}

TEST(MobifVoPlus, NothingToSeeIsNoPose) {
  MobifVoPlus vo(OneCamera(), Fast(), 1);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(vo.Track(Filled(SidewaysFilm().frames[0], i % 2 ? 255 : 0)).pose);
  }
  for (const FrameEstimate& frame : vo.Finish()) EXPECT_FALSE(frame.pose);
}

TEST(MobifVoPlus, WhatCannotBeIsRefused) {
  MobifVoPlusOptions options;
  options.window = 1;
  EXPECT_THROW(MobifVoPlus(OneCamera(), options, 1), BadOption);
  options = {};
  options.feature = "mobiff";
  EXPECT_THROW(MobifVoPlus(OneCamera(), options, 1), BadInput);
}

}  // namespace
}  // namespace gaitcam
