#include "algorithms/odometry/frame_to_frame_vo.h"

#include <gmock/gmock.h>

#include <thread>

#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

FrameToFrameVoOptions Fast() { return FrameToFrameVoOptions::WithFeature("sift", 4); }

TEST(FrameToFrameVo, FollowsABlurredWalkUpToScale) {
  const Film film = FilmPath(
      Room(), kCamera, 100, [](double t) { return WalkPose(t); }, 20, 3);
  FrameToFrameVo vo(kCamera, {}, 1);
  const Estimate estimate = TrackAll(vo, film.frames);
  ExpectSane(estimate);
  EXPECT_EQ(Count(estimate, TrackingStatus::kLost), 0);
  // At 10 cm/s straight ahead it takes two seconds or so until enough points show parallax.
  EXPECT_GE(Count(estimate, TrackingStatus::kTracking), 25);
  const Sim3Error error = AlignedError(estimate, film.truth);
  EXPECT_LT(error.rmse_m, 0.003) << "0.4 mm were measured, on 0.1 m of path with 24 mm of sway";
  for (const FrameEstimate& frame : estimate.frames) EXPECT_FALSE(frame.restarted);
  // The world is the first chosen frame's camera and its unit the median depth there: 1 to 3 m in this room.
  EXPECT_GT(error.scale, 0.5);
  EXPECT_LT(error.scale, 4);
}

struct Composition {
  std::string name;
  FrameToFrameVoOptions options;
};

void PrintTo(const Composition& composition, std::ostream* out) { *out << composition.name; }

std::vector<Composition> Compositions() {
  std::vector<Composition> all;
  for (const auto& [feature, sensitivity] :
       std::vector<std::pair<std::string, double>>{{"mobif", 4}, {"sift", 4}, {"surf", 40}, {"akaze", 4}, {"orb", 4}}) {
    all.push_back({feature, FrameToFrameVoOptions::WithFeature(feature, sensitivity)});
    all.back().options.min_start_points = 25;    // so small a picture has few points of some kinds,
    all.back().options.start_direction_deg = 3;  // and those without sub-pixel places leave the direction less certain
    all.back().options.start_parallax_deg = 1;   // ... so their first depths need more parallax
  }
  for (const std::string estimator : {"ransac", "preemptive"}) {
    all.push_back({estimator, Fast()});
    all.back().options.estimator = estimator;
  }
  all.push_back({"thesis", Fast()});  // the seven steps and nothing else, but for pairs with a baseline
  all.back().options.placing = "two_view";
  all.back().options.refine = false;
  all.back().options.max_direction_deg = 180;
  all.push_back({"points", Fast()});
  all.back().options.placing = "points";
  all.push_back({"exact", Fast()});
  all.back().options.matching.search = "exact";
  return all;
}

class EveryComposition : public testing::TestWithParam<Composition> {};

TEST_P(EveryComposition, FollowsASidewaysMotion) {
  FrameToFrameVo vo(kCamera, GetParam().options, 1);
  const Estimate estimate = TrackAll(vo, SidewaysFilm().frames);
  ExpectSane(estimate);
  EXPECT_LE(Count(estimate, TrackingStatus::kLost), 1);
  ASSERT_GE(Count(estimate, TrackingStatus::kTracking), 15);
  Estimate final_word;
  final_word.frames = vo.Finish();
  const double rmse_m = AlignedError(final_word, SidewaysFilm().truth).rmse_m;
  printf("%-10s %2d frames tracked, %.4f m\n", GetParam().name.c_str(), Count(estimate, TrackingStatus::kTracking),
         rmse_m);
  // On 16 to 27 cm of path; the thesis's steps leave a direction that is good to a degree or so.
  EXPECT_LT(rmse_m, GetParam().name == "thesis" ? 0.02 : 0.01);
}

INSTANTIATE_TEST_SUITE_P(, EveryComposition, testing::ValuesIn(Compositions()),
                         [](const auto& info) { return info.param.name; });

TEST(FrameToFrameVo, SameBitsWhateverTheThreadsAndOpenCvsRandomState) {
  const std::vector<Observation>& frames = SidewaysFilm().frames;
  FrameToFrameVo vo(kCamera, Fast(), 3);
  const Estimate expected = TrackAll(vo, frames);
  ASSERT_GE(Count(expected, TrackingStatus::kTracking), 20);
  Estimate other;
  const int threads = cv::getNumThreads();
  std::thread([&] {
    cv::setNumThreads(1);
    cv::theRNG().state = 0x1234567;
    FrameToFrameVo busy(kCamera, Fast(), 99), again(kCamera, Fast(), 3);
    for (const Observation& frame : frames) {
      if (frame.stamp_ns % 3 == 0) busy.Track(frame);
      other.frames.push_back(again.Track(frame));
    }
  }).join();
  cv::setNumThreads(threads);
  ExpectSameBits(expected, other);
}

TEST(FrameToFrameVo, ColourAndGreyOfTheSamePictureAreTheSame) {
  std::vector<Observation> grey(SidewaysFilm().frames.begin(), SidewaysFilm().frames.begin() + 5), colour = grey;
  for (Observation& frame : colour) cv::cvtColor(frame.image.pixels, frame.image.pixels, cv::COLOR_GRAY2BGR);
  FrameToFrameVo a(kCamera, Fast(), 1), b(kCamera, Fast(), 1);
  ExpectSameBits(TrackAll(a, grey), TrackAll(b, colour));
}

TEST(FrameToFrameVo, ACameraThatStandsStillOrSeesNothingHasNoPoseYet) {
  FrameToFrameVo vo(kCamera, Fast(), 1);
  const Observation& frame = SidewaysFilm().frames[0];
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(vo.Track(Filled(frame, i % 2 ? 255 : 0)).status, TrackingStatus::kInitializing);
  }
  for (int i = 0; i < 8; ++i) {
    const FrameEstimate answer = vo.Track(frame);
    EXPECT_EQ(answer.status, TrackingStatus::kInitializing);
    EXPECT_FALSE(answer.pose);
  }
}

TEST(FrameToFrameVo, ACameraThatOnlyTurnsTriangulatesNothing) {
  const auto turn = [](double t) { return LookingForward({-0.5, 0, 0.4}, 0.3 * t, -0.2, 0.05 * std::sin(5 * t)); };
  const Film film = FilmPath(Room(), kCamera, 25, turn, 10, 2);
  FrameToFrameVo vo(kCamera, Fast(), 1);
  EXPECT_EQ(Count(TrackAll(vo, film.frames), TrackingStatus::kInitializing), 25);
}

TEST(FrameToFrameVo, AFrozenPictureKeepsThePose) {
  FrameToFrameVo vo(kCamera, Fast(), 1);
  const FrameEstimate last = TrackAll(vo, SidewaysFilm().frames).frames.back();
  ASSERT_EQ(last.status, TrackingStatus::kTracking);
  for (int i = 0; i < 6; ++i) {
    const FrameEstimate frozen = vo.Track(SidewaysFilm().frames.back());
    ASSERT_EQ(frozen.status, TrackingStatus::kTracking);
    // The inliers' fit has its noise, and a new pair may be made: a few mm at 3 m, in units of about 3 m.
    EXPECT_LT((frozen.pose->translation - last.pose->translation).norm(), 4e-3);
  }
}

TEST(FrameToFrameVo, FramesExposedThreeTimesTooLongDoNotLoseThePath) {
  std::vector<Observation> frames = SidewaysFilm().frames;
  for (size_t i = 27; i < 32; ++i) frames[i].image.pixels = cv::Mat(frames[i].image.pixels * 3);
  FrameToFrameVo vo(kCamera, Fast(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  ExpectSane(estimate);
  for (size_t i = 32; i < frames.size(); ++i) {
    EXPECT_EQ(estimate.frames[i].status, TrackingStatus::kTracking) << i;
    EXPECT_FALSE(estimate.frames[i].restarted) << i;
  }
}

class EveryMishap : public testing::TestWithParam<Mishap> {};

TEST_P(EveryMishap, IsSurvivedAndThePathFoundAgain) {
  std::vector<Observation> frames = SidewaysFilm().frames;
  for (size_t i = 27; i < 32; ++i) frames[i] = GetParam().befalls(frames[i]);
  FrameToFrameVo vo(kCamera, Fast(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  ExpectSane(estimate);
  for (const FrameEstimate& frame : estimate.frames) EXPECT_FALSE(frame.restarted);
  for (size_t i = 32; i < frames.size(); ++i) EXPECT_EQ(estimate.frames[i].status, TrackingStatus::kTracking) << i;
  for (size_t i = 27; i < 32; ++i) EXPECT_NE(estimate.frames[i].status, TrackingStatus::kInitializing) << i;
  // Frozen frames get the pose of what they show: they are left out of the comparison.
  Estimate rest = estimate;
  rest.frames.erase(rest.frames.begin() + 27, rest.frames.begin() + 32);
  EXPECT_LT(AlignedError(rest, SidewaysFilm().truth).rmse_m, 0.006);
}

INSTANTIATE_TEST_SUITE_P(, EveryMishap, testing::ValuesIn(Mishaps()), [](const auto& info) { return info.param.name; });

TEST(FrameToFrameVo, DroppedFramesAreNoTrouble) {
  std::vector<Observation> frames = SidewaysFilm().frames;
  frames.erase(frames.begin() + 24, frames.begin() + 34);  // a third of a second
  FrameToFrameVo vo(kCamera, Fast(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  EXPECT_EQ(estimate.frames.back().status, TrackingStatus::kTracking);
  EXPECT_LT(AlignedError(estimate, SidewaysFilm().truth).rmse_m, 0.006);
}

TEST(FrameToFrameVo, APathThatStaysLostIsBegunAnewAndMarked) {
  FrameToFrameVoOptions options = Fast();
  options.max_lost_frames = 2;
  std::vector<Observation> frames = SidewaysFilm().frames;
  frames.insert(frames.begin() + 19, 5, Filled(frames[0], 0));
  FrameToFrameVo vo(kCamera, options, 1);
  const Estimate estimate = TrackAll(vo, frames);
  ExpectSane(estimate);
  int restarts = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameEstimate& frame = estimate.frames[i];
    restarts += frame.restarted;
    EXPECT_TRUE(!frame.restarted || i > 24) << i;
    EXPECT_TRUE(i < 19 || i > 24 || frame.status == TrackingStatus::kLost) << i;
  }
  EXPECT_EQ(restarts, 1);
  EXPECT_EQ(estimate.frames.back().status, TrackingStatus::kTracking);
}

TEST(FrameToFrameVo, TheFinalWordPlacesTheFramesThatWaitedForABeginning) {
  FrameToFrameVoOptions options = Fast();
  options.max_lost_frames = 2;
  std::vector<Observation> frames = SidewaysFilm().frames;
  frames.insert(frames.begin() + 19, 5, Filled(frames[0], 0));
  FrameToFrameVo vo(kCamera, options, 1);
  const Estimate live = TrackAll(vo, frames);
  Estimate final_word;
  final_word.frames = vo.Finish();
  ASSERT_EQ(final_word.frames.size(), frames.size());
  ExpectSane(final_word);
  EXPECT_EQ(final_word.frames[0].status, TrackingStatus::kTracking);
  EXPECT_GT(Count(final_word, TrackingStatus::kTracking), Count(live, TrackingStatus::kTracking));
  int restarts = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    restarts += final_word.frames[i].restarted;
    if (i < 19 || i >= 24) continue;
    EXPECT_FALSE(final_word.frames[i].pose) << "a black frame has no pose";
  }
  EXPECT_EQ(restarts, 1);
}

TEST(FrameToFrameVo, NoiseIsNotTakenForAWorld) {
  RandomStream random(1, "noise");
  FrameToFrameVo vo(kCamera, Fast(), 1);
  for (int i = 0; i < 8; ++i) {
    Observation frame = SidewaysFilm().frames[0];
    frame.image.pixels = frame.image.pixels.clone();
    for (uchar& grey : cv::Mat_<uchar>(frame.image.pixels)) grey = uchar(random.Index(256));
    EXPECT_FALSE(vo.Track(frame).pose);
  }
}

TEST(FrameToFrameVo, WhatCannotBeIsRefused) {
  EXPECT_THROW(FrameToFrameVo(CameraModel(), {}, 1), BadOption);
  FrameToFrameVoOptions options;
  options.matching.ratio = 1.2;
  try {
    FrameToFrameVo vo(kCamera, options, 1);
    FAIL() << "a ratio above 1 was taken";
  } catch (const BadOption& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("ratio: 1.2 is not permitted; expected a number from 0.1 to 1"));
  }
  FrameToFrameVo vo(kCamera, {}, 1);
  Observation small = SidewaysFilm().frames[0];
  small.image.pixels = cv::Mat::zeros(10, 20, CV_8UC1);
  EXPECT_THROW(vo.Track(small), BadInput);
}

}  // namespace
}  // namespace gaitcam
