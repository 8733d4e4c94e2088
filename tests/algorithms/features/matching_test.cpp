#include "algorithms/features/matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

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

TEST(Matching, NothingMatchesNothing) {
  EXPECT_TRUE(MatchDescriptors({}, RandomDescriptors(3, "a"), {}).empty());
  EXPECT_TRUE(MatchDescriptors(RandomDescriptors(3, "a"), {}, {}).empty());
  EXPECT_EQ(MatchDescriptors(RandomDescriptors(3, "a"), RandomDescriptors(1, "a"), {}).size(), 1u);
}

}  // namespace
}  // namespace gaitcam
