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

}  // namespace
}  // namespace gaitcam
