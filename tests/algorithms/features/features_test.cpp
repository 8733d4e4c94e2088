#include "algorithms/features/features.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
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

std::vector<cv::Point2f> Places(const Features& features) {
  std::vector<cv::Point2f> places;
  for (const cv::KeyPoint& keypoint : features.keypoints) places.push_back(keypoint.pt);
  return places;
}

/// Each property holds for every detector there is.
class EveryDetector : public testing::TestWithParam<std::string> {
 protected:
  Features Detect(const cv::Mat& image, int most = 400) const {
    return DetectFeatures(*MakeFeature2d(GetParam()), image, most);
  }
};

TEST_P(EveryDetector, KeepsTheStrongestAndNoMore) {
  const cv::Mat image = Discs(300);
  const Features all = Detect(image, 100000);
  ASSERT_GT(all.size(), 60);
  const Features some = Detect(image, 50);
  ASSERT_EQ(some.size(), 50);
  EXPECT_EQ(some.descriptors.rows, 50);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(some.keypoints[size_t(i)].pt, all.keypoints[size_t(i)].pt);
    EXPECT_EQ(cv::norm(some.descriptors.row(i), all.descriptors.row(i), cv::NORM_INF), 0);
  }
}

TEST_P(EveryDetector, TheSameWhateverTheNumberOfThreads) {
  const cv::Mat image = Discs(300);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Features one = Detect(image);
  cv::setNumThreads(8);
  const Features eight = Detect(image);
  cv::setNumThreads(threads);
  ASSERT_EQ(one.size(), eight.size());
  EXPECT_EQ(Places(one), Places(eight));
  EXPECT_EQ(cv::norm(one.descriptors, eight.descriptors, cv::NORM_INF), 0);
}

TEST_P(EveryDetector, NoTextureNoFeatures) {
  EXPECT_EQ(Detect(cv::Mat::zeros(240, 320, CV_8UC1)).size(), 0);
  EXPECT_EQ(Detect(cv::Mat(240, 320, CV_8UC3, cv::Scalar(200, 200, 200))).size(), 0);
}

TEST_P(EveryDetector, MoreSensitiveFindsNoFewer) {
  const cv::Mat image = Discs(60);
  const int usual = DetectFeatures(*MakeFeature2d(GetParam()), image, 100000).size();
  EXPECT_GE(DetectFeatures(*MakeFeature2d(GetParam(), 4), image, 100000).size(), usual);
}

INSTANTIATE_TEST_SUITE_P(Features, EveryDetector, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const FeatureInfo& info : ListFeatures()) names.push_back(info.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

TEST(Features, APixelsCentreIsWhereOpenCvPutsIt) {
  // One disc around the centre of pixel (160, 120): the strongest feature must be there, not half a pixel beside.
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(50));
  cv::circle(image, {160, 120}, 9, cv::Scalar(220), cv::FILLED, cv::LINE_AA);
  const Features features = DetectFeatures(*MakeFeature2d("sift"), image, 100);
  ASSERT_GT(features.size(), 0);
  EXPECT_NEAR(features.keypoints[0].pt.x, 160, 0.3);  // OpenCV 4.6 places features up to 0.25 px off
  EXPECT_NEAR(features.keypoints[0].pt.y, 120, 0.3);
}

TEST(Features, AnUnknownDetectorIsNamedWithTheNearest) {
  try {
    MakeFeature2d("akase");
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean akaze"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace gaitcam
