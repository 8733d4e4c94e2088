#include "algorithms/features/matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

cv::Mat RandomDescriptors(int rows, const std::string& name) {
  RandomStream random(1, name);
  cv::Mat descriptors(rows, 128, CV_32FC1);
  for (float& value : cv::Mat_<float>(descriptors)) value = float(random.Index(200));
  return descriptors;
}

double Distance(const cv::Mat& a, int i, const cv::Mat& b, int j) { return cv::norm(a.row(i), b.row(j)); }

TEST(Matching, FindsEachDescriptorsNearest) {
  const cv::Mat a = RandomDescriptors(40, "a"), b = RandomDescriptors(60, "b");
  const auto matches = MatchDescriptors(a, b, {1.0, false});
  ASSERT_EQ(matches.size(), 40u);
  for (const Match& match : matches) {
    for (int j = 0; j < b.rows; ++j) EXPECT_GE(Distance(a, match.a, b, j), Distance(a, match.a, b, match.b));
    // Squared distances of some 1e6 are computed as differences of floats: 1e-7 relative, 0.1 absolute in the square.
    EXPECT_NEAR(match.distance, Distance(a, match.a, b, match.b), 1e-2);
  }
}

TEST(Matching, APermutationIsFoundAgainInOrder) {
  const cv::Mat a = RandomDescriptors(50, "a");
  cv::Mat b(50, 128, CV_32FC1);
  for (int i = 0; i < 50; ++i) a.row(i).copyTo(b.row((i * 7 + 3) % 50));
  const auto matches = MatchDescriptors(a, b, {0.8, true});
  ASSERT_EQ(matches.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(matches[size_t(i)].a, i);
    EXPECT_EQ(matches[size_t(i)].b, (i * 7 + 3) % 50);
  }
}

TEST(Matching, TheRatioTestDropsWhatHasADouble) {
  const cv::Mat a = RandomDescriptors(10, "a");
  cv::Mat b = a.clone();
  b.push_back(a.row(4));
  b.at<float>(10, 0) += 1;
  const auto matches = MatchDescriptors(a + 2, b, {0.8, false});
  EXPECT_EQ(matches.size(), 9u);
  for (const Match& match : matches) EXPECT_NE(match.a, 4);
}

TEST(Matching, MutualPairsUseEachDescriptorOnce) {
  const cv::Mat a = RandomDescriptors(200, "a"), b = RandomDescriptors(20, "b");
  std::vector<int> used(20);
  for (const Match& match : MatchDescriptors(a, b, {1.0, true})) ++used[size_t(match.b)];
  for (const int count : used) EXPECT_LE(count, 1);
  EXPECT_GT(std::count(used.begin(), used.end(), 1), 0);
}

cv::Mat RandomBits(int rows, const std::string& name) {
  RandomStream random(1, name);
  cv::Mat descriptors(rows, 32, CV_8UC1);
  for (uchar& value : cv::Mat_<uchar>(descriptors)) value = uchar(random.Index(256));
  return descriptors;
}

TEST(Matching, BinaryDescriptorsAreComparedBitByBit) {
  const cv::Mat a = RandomBits(40, "a");
  cv::Mat b = a.clone();
  for (int i = 0; i < 40; ++i) b.at<uchar>(i, i % 32) ^= 0x11;  // two bits of 256; random pairs differ in some 128
  const auto matches = MatchDescriptors(a, b, {0.8, true});
  ASSERT_EQ(matches.size(), 40u);
  for (const Match& match : matches) {
    EXPECT_EQ(match.a, match.b);
    EXPECT_EQ(match.distance, 2);
  }
}

TEST(Matching, StrategiesDifferInWhatTheyAskFor) {
  cv::Mat a(1, 2, CV_32FC1, cv::Scalar(0)), b = (cv::Mat_<float>(3, 2) << 3, 0, 0, 4, 20, 0);
  MatchingOptions options;
  options.mutual = false;
  EXPECT_EQ(MatchDescriptors(a, b, options).size(), 1u);  // 3 of 4 is 0.75
  options.ratio = 0.7;
  EXPECT_EQ(MatchDescriptors(a, b, options).size(), 0u);
  options.strategy = MatchStrategy::kNearest;
  EXPECT_EQ(MatchDescriptors(a, b, options).size(), 1u);
  options.max_distance = 2.9;
  EXPECT_EQ(MatchDescriptors(a, b, options).size(), 0u);
  options.strategy = MatchStrategy::kThreshold;
  options.max_distance = 4.1;
  const auto all_near = MatchDescriptors(a, b, options);
  ASSERT_EQ(all_near.size(), 2u);
  EXPECT_EQ(all_near[1].b, 1);
  EXPECT_FLOAT_EQ(all_near[1].distance, 4);
  options.max_distance = 0;
  EXPECT_THROW(MatchDescriptors(a, b, options), BadOption);
}

TEST(Matching, NothingMatchesNothing) {
  EXPECT_TRUE(MatchDescriptors({}, RandomDescriptors(3, "a"), {}).empty());
  EXPECT_TRUE(MatchDescriptors(RandomDescriptors(3, "a"), {}, {}).empty());
  EXPECT_EQ(MatchDescriptors(RandomDescriptors(3, "a"), RandomDescriptors(1, "a"), {}).size(), 1u);
}

}  // namespace
}  // namespace gaitcam
