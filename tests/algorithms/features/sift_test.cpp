#include "algorithms/features/sift.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

cv::Mat Discs(int count, const cv::Point& shift = {0, 0}) {
  RandomStream random(1, "discs");
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < count; ++i) {
    const cv::Point centre(random.Index(320), random.Index(240));
    cv::circle(image, centre + shift, 3 + random.Index(12), cv::Scalar(random.Index(256)), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.8);
  return image;
}

TEST(Sift, KeepsTheStrongestAndNoMore) {
  const cv::Mat image = Discs(300);
  SiftOptions options;
  options.max_features = 100000;
  const Features all = DetectSift(image, options);
  ASSERT_GT(all.size(), 150);
  options.max_features = 100;
  const Features some = DetectSift(image, options);
  ASSERT_EQ(some.size(), 100);
  EXPECT_EQ(some.descriptors.rows, 100);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(some.pixels[size_t(i)], all.pixels[size_t(i)]);
    EXPECT_EQ(cv::norm(some.descriptors.row(i), all.descriptors.row(i), cv::NORM_INF), 0);
  }
}

TEST(Sift, TheSameWhateverTheNumberOfThreads) {
  const cv::Mat image = Discs(300);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Features one = DetectSift(image, {});
  cv::setNumThreads(8);
  const Features eight = DetectSift(image, {});
  cv::setNumThreads(threads);
  ASSERT_EQ(one.size(), eight.size());
  EXPECT_EQ(one.pixels, eight.pixels);
  EXPECT_EQ(cv::norm(one.descriptors, eight.descriptors, cv::NORM_INF), 0);
}

TEST(Sift, NoTextureNoFeatures) {
  EXPECT_EQ(DetectSift(cv::Mat::zeros(240, 320, CV_8UC1), {}).size(), 0);
  EXPECT_EQ(DetectSift(cv::Mat(240, 320, CV_8UC3, cv::Scalar(200, 200, 200)), {}).size(), 0);
}

TEST(Sift, APixelsCentreIsWhereOpenCvPutsIt) {
  // One disc around the centre of pixel (160, 120): the strongest feature must be there, not half a pixel beside.
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(50));
  cv::circle(image, {160, 120}, 9, cv::Scalar(220), cv::FILLED, cv::LINE_AA);
  const Features features = DetectSift(image, {});
  ASSERT_GT(features.size(), 0);
  EXPECT_NEAR(features.pixels[0].x, 160, 0.3);  // OpenCV 4.6 places features of its doubled octave up to 0.25 px off
  EXPECT_NEAR(features.pixels[0].y, 120, 0.3);
}

}  // namespace
}  // namespace gaitcam
