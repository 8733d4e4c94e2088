#include "algorithms/features/descriptor_entropy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

TEST(DescriptorEntropy, IsLogOfTheNumberOfEqualEntries) {
  cv::Mat d = cv::Mat::zeros(3, 128, CV_32FC1);
  d.row(0) = 0.3;
  d.at<float>(1, 7) = 0.9f;
  const std::vector<double> h = DescriptorEntropies(d);
  EXPECT_NEAR(h[0], std::log(128.0), 1e-6);
  EXPECT_EQ(h[1], 0);
  EXPECT_EQ(h[2], 0);  // a row of zeros
}

TEST(DescriptorEntropy, DiscardsThoseMoreThanADeviationBelowTheMean) {
  Features features;
  features.descriptors = cv::Mat::zeros(10, 128, CV_32FC1);
  for (int i = 0; i < 10; ++i) {
    features.keypoints.emplace_back(cv::Point2f(float(i), 0), 1.f);
    features.descriptors.row(i).colRange(0, i == 4 ? 2 : 100 + i) = 1;  // the fifth has two entries only
  }
  const Features kept = DiscardLowEntropy(features);
  ASSERT_EQ(kept.size(), 9);
  ASSERT_EQ(kept.descriptors.rows, 9);
  for (const cv::KeyPoint& k : kept.keypoints) EXPECT_NE(k.pt.x, 4);
  EXPECT_EQ(cv::norm(kept.descriptors.row(4), features.descriptors.row(5)), 0);  // rows stay with their keypoints
}

TEST(DescriptorEntropy, KeepsAllWhenAllSayAsMuch) {
  Features features;
  features.descriptors = cv::Mat::ones(5, 128, CV_32FC1);
  features.keypoints.resize(5);
  EXPECT_EQ(DiscardLowEntropy(features).size(), 5);
  EXPECT_EQ(DiscardLowEntropy({}).size(), 0);
}

}  // namespace
}  // namespace gaitcam
