#include "algorithms/odometry/sharp_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// Of the frames of a walk that takes ten a step.
std::vector<double> Blurs() {
  std::vector<double> blurs;
  for (int i = 0; i < 120; ++i) blurs.push_back(1.1 + std::sin(2 * M_PI * i / 10 + 0.1));
  return blurs;
}

TEST(SharpFrames, AboutAThirdOfAStepIsSharp) {
  SharpFrames frames(0);
  int sharp = 0, sharpest = 0;
  const std::vector<double> blurs = Blurs();
  for (size_t i = 0; i < blurs.size(); ++i) {
    const bool is_sharp = frames.Add(blurs[i]);
    if (i < 20) continue;
    sharp += is_sharp;
    sharpest += is_sharp && blurs[i] < 0.3;
    EXPECT_FALSE(is_sharp && blurs[i] > 1.3) << i;
  }
  EXPECT_NEAR(sharp, 35, 10) << "of 100";
  EXPECT_EQ(sharpest, 20) << "two a step";
}

TEST(SharpFrames, WhereAllAreAboutAlikeAllAreSharp) {
  SharpFrames frames(0.1);
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(frames.Add(1 + 0.04 * std::sin(i))) << i;
}

TEST(FineDetail, FallsAsAnImageIsBlurredWhateverItsMeanBrightness) {
  RandomStream random(1, "sharp_frames_test");
  cv::Mat image(120, 160, CV_8UC3);
  for (cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(image)) pixel = cv::Vec3b::all(uchar(60 + random.Index(100)));
  cv::GaussianBlur(image, image, {}, 1.5);
  double last = FineDetail(image);
  EXPECT_NEAR(FineDetail(image + cv::Scalar::all(40)), last, 0.01 * last);
  for (const int extent : {3, 7, 15}) {
    cv::Mat blurred;
    cv::blur(image, blurred, {extent, 1});
    EXPECT_LT(FineDetail(blurred), 0.9 * last) << extent;
    last = FineDetail(blurred);
  }
}

constexpr int64_t kTenth_ns = 100'000'000;

/// Detail of a walk's frames, three a step, the sharpest of 10; it stands still for the first second.
std::vector<double> Details(double shaken, double between) {
  std::vector<double> details(10, 10.0);
  for (int i = 0; i < 60; ++i) details.push_back(i % 3 == 0 ? 10 : i % 3 == 1 ? shaken : between);
  return details;
}

/// How many of the frames, ten a second, are said to be clear, of those from the twelfth with a map on, if a map is
/// there from a frame on.
double ClearPart(const std::vector<double>& details, size_t map_from) {
  ClearWalk walk;
  int clear = 0;
  for (size_t i = 0; i < details.size(); ++i) {
    const bool is_clear = walk.Add(int64_t(i) * kTenth_ns, details[i], i >= map_from);
    EXPECT_FALSE(is_clear && i < map_from + 11) << i << ": too early to say";
    clear += is_clear;
  }
  return double(clear) / double(details.size() - map_from - 11);
}

TEST(ClearWalk, IsTheOneThatTakesLittleDetailAway) {
  EXPECT_EQ(ClearPart(Details(4, 8), 20), 1);
  EXPECT_EQ(ClearPart(Details(3, 5), 20), 0);
  EXPECT_EQ(ClearPart(std::vector<double>(70, 10.0), 20), 1) << "a film without blur";
  EXPECT_EQ(ClearPart(std::vector<double>(70, 0.0), 20), 0) << "of nothing";
}

TEST(ClearWalk, DoesNotWaverBetweenItsLimits) {
  ClearWalk walk;
  int64_t stamp_ns = 0;
  const auto add = [&](double typical) {
    bool is_clear = false;
    for (int i = 0; i < 12; ++i) is_clear = walk.Add(stamp_ns += kTenth_ns, i % 4 == 0 ? 10 : typical, true);
    return is_clear;
  };
  EXPECT_FALSE(add(6.8)) << "never clear yet";
  EXPECT_TRUE(add(8));
  EXPECT_TRUE(add(6.8));
  EXPECT_FALSE(add(5));
  EXPECT_FALSE(add(6.8));
}

TEST(ClearWalk, BeginsAnewWithEachMap) {
  ClearWalk walk;
  int64_t stamp_ns = 0;
  const auto add = [&](bool has_map) { return walk.Add(stamp_ns += kTenth_ns, 10, has_map); };
  for (int i = 0; i < 12; ++i) add(true);
  EXPECT_TRUE(add(true));
  EXPECT_FALSE(add(false));
  for (int i = 0; i < 11; ++i) EXPECT_FALSE(add(true)) << i;
  EXPECT_TRUE(add(true));
}

/// Of each step of 0.5 s the camera is shaken for 0.4 s, then for 0.1 s: 0.3 s of frames may show shaken ones alone.
TEST(ClearWalk, SaysTheSameAtEachFrameRate) {
  constexpr int64_t kStep_ms = 500, kBefore_ms = 1200;
  for (const int64_t frame_ms : {100, 25, 10}) {
    for (const int64_t still_ms : {100, 400}) {
      ClearWalk walk;
      for (int64_t time_ms = 0; time_ms < 10'000; time_ms += frame_ms) {
        const double detail = time_ms % kStep_ms < still_ms ? 10 : 5;
        const bool is_clear = walk.Add(time_ms * 1'000'000, detail, true);
        if (time_ms > kBefore_ms) EXPECT_EQ(is_clear, still_ms == 400) << frame_ms << " ms, " << time_ms << " ms";
      }
    }
  }
}

}  // namespace
}  // namespace gaitcam
