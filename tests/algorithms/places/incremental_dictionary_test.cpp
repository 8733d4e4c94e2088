#include "algorithms/places/incremental_dictionary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "made_up_words.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::DoubleEq;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

DictionaryOptions Exact() {
  DictionaryOptions options;
  options.max_distance = 0.5;  // words are about 1.4 apart, copies some 0.2
  options.max_candidates = 0;
  return options;
}

TEST(IncrementalDictionary, LearnsEachFeatureOnceAndFindsItAgain) {
  const cv::Mat things = UnitRows(300, 64, 1);
  RandomStream random(1, "noise");
  IncrementalDictionary dictionary(Exact());
  std::vector<int> all(300);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_THAT(dictionary.Find(things), Each(-1));
  EXPECT_EQ(dictionary.Learn(SeenRows(things, all, 0.1, random).descriptors), all);  // words are numbered as they come
  for (int again = 0; again < 3; ++again) {
    const cv::Mat seen = SeenRows(things, all, 0.1, random).descriptors;
    EXPECT_EQ(dictionary.Find(seen), all);
    EXPECT_EQ(dictionary.Learn(seen), all);
  }
  EXPECT_EQ(dictionary.size(), 300);
  EXPECT_THAT(dictionary.Find(UnitRows(50, 64, 2)), Each(-1));  // other things
}

TEST(IncrementalDictionary, OneImageThatShowsAThingTwiceLearnsOneWord) {
  const cv::Mat things = UnitRows(3, 64, 1);
  RandomStream random(1, "noise");
  IncrementalDictionary dictionary(Exact());
  EXPECT_THAT(dictionary.Learn(SeenRows(things, {2, 0, 2}, 0.1, random).descriptors), ElementsAre(0, 1, 0));
}

TEST(IncrementalDictionary, WordsThatAreBitsAreToldApartByHowManyDiffer) {
  RandomStream random(2, "bits");
  cv::Mat things(20, 32, CV_8UC1);
  for (uchar& byte : cv::Mat_<uchar>(things)) byte = uchar(random.Index(256));
  DictionaryOptions options;
  options.max_distance = 8;
  options.max_candidates = 0;
  IncrementalDictionary dictionary(options);
  dictionary.Learn(things);
  cv::Mat near = things.clone(), far = things.clone();
  for (int row = 0; row < near.rows; ++row) {
    near.at<uchar>(row, 5) ^= 0xff;                                // 8 bits
    far.at<uchar>(row, 5) ^= 0xff, far.at<uchar>(row, 6) ^= 0x01;  // 9 bits
  }
  std::vector<int> all(20);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(dictionary.Find(near), all);
  EXPECT_THAT(dictionary.Find(far), Each(-1));
}

TEST(IncrementalDictionary, AHundredCandidatesFindNearlyAllOfTenThousandWords) {
  const cv::Mat things = UnitRows(10000, 64, 3);
  RandomStream random(3, "noise");
  IncrementalDictionary dictionary;
  dictionary.Learn(things);
  EXPECT_EQ(dictionary.size(), 10000);
  std::vector<int> asked;
  for (int k = 0; k < 500; ++k) asked.push_back(random.Index(10000));
  const std::vector<int> found = dictionary.Find(SeenRows(things, asked, 0.1, random).descriptors);
  int right = 0;
  for (size_t k = 0; k < asked.size(); ++k) right += found[k] == asked[k];
  // Directions drawn evenly in 64 dimensions are the hardest there are to search; real features crowd.
  EXPECT_GT(right, 0.9 * 500);
}

TEST(IncrementalDictionary, ScoreIsTheSumOfInverseDocumentFrequencies) {
  IncrementalDictionary dictionary(Exact());
  dictionary.Learn(UnitRows(5, 64, 1));
  dictionary.AddPlace({0, 1, 2});
  dictionary.AddPlace({0, 3});
  dictionary.AddPlace({0, 1});
  dictionary.AddPlace({4});
  const double in_one = std::log(4.0), in_two = std::log(2.0), in_three = std::log(4.0 / 3);
  EXPECT_THAT(dictionary.Score({0, 1, 3}, 4),
              ElementsAre(DoubleEq(in_three + in_two), DoubleEq(in_three + in_one), DoubleEq(in_three + in_two), 0));
  // Of the first two places both show word 0: it says nothing of them.
  EXPECT_THAT(dictionary.Score({0, 1}, 2), ElementsAre(DoubleEq(std::log(2.0)), 0));
  EXPECT_THAT(dictionary.Score({}, 4), Each(0));
  EXPECT_TRUE(dictionary.Score({0}, 0).empty());
}

TEST(IncrementalDictionary, MemoryGrowsWithWhatIsNewOnly) {
  const cv::Mat things = UnitRows(200, 64, 1);
  IncrementalDictionary dictionary(Exact());
  dictionary.AddPlace(KnownWords(dictionary.Learn(things)));
  const size_t first = dictionary.bytes();
  EXPECT_GT(first, size_t(200 * 64 * 4));
  for (int place = 0; place < 10; ++place) dictionary.AddPlace(KnownWords(dictionary.Learn(things)));
  EXPECT_LT(dictionary.bytes() - first, size_t(200 * 16 * 4));  // a number for each place, in blocks
}

TEST(IncrementalDictionary, SaysWhatIsWrongInOneLine) {
  DictionaryOptions options;
  options.max_distance = 0;
  EXPECT_THAT(ErrorOf([&] { IncrementalDictionary{options}; }), HasSubstr("dictionary.max_distance"));
  IncrementalDictionary dictionary;
  EXPECT_THAT(ErrorOf([&] { dictionary.Learn(cv::Mat(1, 8, CV_64FC1)); }), HasSubstr("CV_32FC1 or CV_8UC1"));
  dictionary.Learn(UnitRows(3, 64, 1));
  EXPECT_THAT(ErrorOf([&] { dictionary.Learn(UnitRows(3, 128, 1)); }),
              HasSubstr("128 columns (float); the dictionary has 64 columns (float)"));
  EXPECT_THAT(ErrorOf([&] { dictionary.Find(cv::Mat(1, 64, CV_8UC1)); }), HasSubstr("64 columns (binary)"));
}

}  // namespace
}  // namespace gaitcam
