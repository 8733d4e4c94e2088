#include "algorithms/features/light_response.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

/// Grey values of light that was blurred before the response.
cv::Mat BlurLight(const cv::Mat& grey, const LineBlur& blur, int margin_px) {
  cv::Mat light = LightOfGrey(grey), scaled, filmed;
  light.convertTo(scaled, CV_8U, 255);  // eight bits are enough to tell the two apart
  cv::Mat blurred;
  BlurAndCrop(scaled, blur, margin_px).convertTo(blurred, CV_32F, 1 / 255.0);
  GreyOfLight(blurred).convertTo(filmed, CV_8U, 255);
  return filmed;
}

TEST(LightResponse, GreyAndLightAreEachOthersInverse) {
  cv::Mat grey(1, 256, CV_8UC1);
  for (int v = 0; v < 256; ++v) grey.at<uchar>(v) = uchar(v);
  const cv::Mat back = GreyOfLight(LightOfGrey(grey));
  for (int v = 0; v < 256; ++v) EXPECT_NEAR(back.at<float>(v), v / 255.0, 2e-4) << v;
  EXPECT_EQ(GreyOfLight(cv::Mat(1, 1, CV_32FC1, cv::Scalar(-0.1))).at<float>(0), 0);
  EXPECT_NEAR(GreyOfLight(cv::Mat(1, 1, CV_32FC1, cv::Scalar(1.5))).at<float>(0), std::pow(1.5, 1 / 2.2), 1e-5);
}

TEST(LightResponse, TellsWhetherLightOrGreyValuesWereAddedUp) {
  int right = 0, cases = 0;
  for (const double extent : {8.0, 14.0, 40.0})
    for (const uint64_t seed : {1, 2}) {
      const LineBlur blur{extent, 0.5 * double(seed) + 0.1};
      const cv::Mat picture = RandomPicture({480, 400}, seed);
      right += BlurActedOnLight(BlurLight(picture, blur, 24), blur);
      right += !BlurActedOnLight(BlurAndCrop(picture, blur, 24), blur);
      cases += 2;
    }
  EXPECT_GE(right, cases - 1);
}

}  // namespace
}  // namespace gaitcam
