#include "algorithms/planes/alignment_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// What a camera with an sRGB response makes of light from 0 to 1.
uchar Display(double light) {
  const double display = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
  return cv::saturate_cast<uchar>(255 * display);
}

cv::Mat Picture(const cv::Mat& light) {
  cv::Mat image(light.size(), CV_8UC1);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) image.at<uchar>(v, u) = Display(light.at<double>(v, u));
  }
  return image;
}

TEST(AlignmentImage, ABlurredPictureIsTheMeanOfSharpOnes) {
  RandomStream random(1, "light");
  cv::Mat light(40, 60, CV_64FC1), moved;
  for (int i = 0; i < int(light.total()); ++i) light.at<double>(i / 60, i % 60) = random.Uniform() < 0.5 ? 0.02 : 0.9;
  cv::flip(light, moved, 1);
  const cv::Mat blurred = AlignmentImage(Picture(0.5 * (light + moved)));
  const cv::Mat mean = 0.5 * (AlignmentImage(Picture(light)) + AlignmentImage(Picture(moved)));
  // One of 256 display values is at most 2.3 of 255 in light (at white, by the response's slope); rounded, half of it.
  EXPECT_LT(cv::norm(blurred, mean, cv::NORM_INF), 1.2);
  cv::Mat display_mean;
  cv::addWeighted(Picture(light), 0.5, Picture(moved), 0.5, 0, display_mean);
  EXPECT_GT(cv::norm(AlignmentImage(display_mean), mean, cv::NORM_INF), 20);  // as if display values added up
}

TEST(AlignmentImage, BlackAndWhiteStayAndGreyIsItsLight) {
  for (const auto& [display, light] : {std::pair(0, 0.0), std::pair(255, 255.0), std::pair(188, 255 * 0.5029)}) {
    const cv::Mat image = AlignmentImage(cv::Mat(20, 20, CV_8UC1, cv::Scalar(double(display))));
    ASSERT_EQ(image.type(), CV_32FC1);
    EXPECT_NEAR(image.at<float>(0, 0), light, 0.01);
    EXPECT_NEAR(image.at<float>(10, 10), light, 0.01);
  }
}

TEST(AlignmentImage, IsSmoothedByOnePixel) {
  cv::Mat point(31, 31, CV_8UC1, cv::Scalar(0));
  point.at<uchar>(15, 15) = 255;
  const cv::Mat image = AlignmentImage(point);
  double sum = 0, spread = 0;
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      sum += image.at<float>(v, u);
      spread += image.at<float>(v, u) * (u - 15) * (u - 15);
    }
  }
  EXPECT_NEAR(sum, 255, 0.1);
  EXPECT_NEAR(spread / sum, 1, 0.05);  // the filter ends at three standard deviations
}

TEST(AlignmentImage, ColourIsTakenForItsGrey) {
  const cv::Mat grey(20, 20, CV_8UC1, cv::Scalar(77));
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  EXPECT_EQ(cv::norm(AlignmentImage(grey), AlignmentImage(colour), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gaitcam
