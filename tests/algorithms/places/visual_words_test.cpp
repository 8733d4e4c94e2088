#include "algorithms/places/visual_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "made_up_words.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Sum over the true centres of the distance to the nearest word, the least over several seeds: whichever rows are
/// drawn to begin with, of several seeds one at least begins in all centres.
double LeastDistance(const cv::Mat& descriptors, const cv::Mat& centres, cv::NormTypes norm) {
  double best = 1e300;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const cv::Mat words = LearnWords(descriptors, centres.rows, seed);
    double sum = 0;
    for (int k = 0; k < centres.rows; ++k) {
      double nearest = 1e300;
      for (int word = 0; word < words.rows; ++word)
        nearest = std::min(nearest, cv::norm(centres.row(k), words.row(word), norm));
      sum += nearest;
    }
    best = std::min(best, sum);
  }
  return best;
}

TEST(VisualWords, OfBitsAreTheCentresThatDescriptorsWereDrawnAbout) {
  RandomStream random(3, "descriptors");
  cv::Mat centres(4, 32, CV_8UC1), descriptors;
  for (int k = 0; k < 4 * 32; ++k) centres.at<uchar>(k / 32, k % 32) = uchar(random.Index(256));
  for (int k = 0; k < 400; ++k) {
    cv::Mat noisy = centres.row(k % 4).clone();
    for (int flip = 0; flip < 20; ++flip) noisy.at<uchar>(0, random.Index(32)) ^= uchar(1 << random.Index(8));
    descriptors.push_back(noisy);
  }
  EXPECT_LE(LeastDistance(descriptors, centres, cv::NORM_HAMMING), 2);
}

TEST(VisualWords, OfFloatsAreTheCentresThatDescriptorsWereDrawnAbout) {
  RandomStream random(3, "descriptors");
  const cv::Mat centres = UnitRows(4, 64, 1);
  cv::Mat descriptors;
  for (int k = 0; k < 400; ++k) descriptors.push_back(SeenRows(centres, {k % 4}, 0.4, random).descriptors);
  // A mean of 100 rows that are 0.4 off: 0.04 off; four of them.
  EXPECT_LT(LeastDistance(descriptors, centres, cv::NORM_L2), 4 * 0.06);
}

TEST(VisualWords, AreTheSameForTheSameSeed) {
  const cv::Mat descriptors = UnitRows(200, 64, 2);
  EXPECT_EQ(cv::norm(LearnWords(descriptors, 10, 5), LearnWords(descriptors, 10, 5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(LearnWords(descriptors, 10, 5), LearnWords(descriptors, 10, 6), cv::NORM_INF), 0);
}

TEST(VisualWords, OfAnImageAreSortedAndEachOnce) {
  RandomStream random(4, "image");
  const cv::Mat words = UnitRows(20, 64, 3);
  EXPECT_THAT(WordsIn(SeenRows(words, {7, 3, 7, 12}, 0.1, random).descriptors, words), ElementsAre(3, 7, 12));
  EXPECT_TRUE(WordsIn(cv::Mat(), words).empty());
}

TEST(VisualWords, WeighTheLessTheMoreDocumentsShowThem) {
  const std::vector<double> idf = InverseDocumentFrequency({{0, 1}, {0}, {0, 1}}, 3);
  EXPECT_THAT(idf, ElementsAre(testing::DoubleEq(std::log(4 / 3.5)), testing::DoubleEq(std::log(4 / 2.5)),
                               testing::DoubleEq(std::log(4 / 0.5))));
  EXPECT_THAT(InverseDocumentFrequency({}, 1), ElementsAre(testing::DoubleEq(std::log(2.0))));
}

TEST(VisualWords, SayWhatIsWrongInOneLine) {
  const cv::Mat rows = UnitRows(5, 64, 1);
  EXPECT_THAT(ErrorOf([&] { LearnWords(rows, 6, 1); }), HasSubstr("5 features in the training images are too few"));
  EXPECT_THAT(ErrorOf([&] { LearnWords(rows, 0, 1); }), HasSubstr("needs one at least"));
  EXPECT_THAT(ErrorOf([&] { NearestWords(rows, cv::Mat()); }), HasSubstr("the vocabulary is empty"));
  EXPECT_THAT(ErrorOf([&] { NearestWords(rows.colRange(0, 32), rows); }),
              HasSubstr("32 columns (float); the vocabulary has 64 columns (float)"));
  EXPECT_THAT(ErrorOf([&] { NearestWords(cv::Mat(2, 64, CV_8UC1), rows); }), HasSubstr("64 columns (binary)"));
}

}  // namespace
}  // namespace gaitcam
