#include "algorithms/slam/hybrid_loops.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

constexpr int kPlaces = 20;

/// What a place shows: eight words of its own and eight that it shares with the next place.
cv::Mat Place(int place) {
  cv::Mat rows;
  for (int word = 8 * place; word < 8 * place + 16; ++word) {
    RandomStream random(uint64_t(word % (8 * kPlaces)), "word");
    cv::Mat row(1, 16, CV_32FC1);
    for (float& value : cv::Mat_<float>(row)) value = float(random.Normal());
    rows.push_back(row);
  }
  return rows;
}

PassSearch AfterRounds(int rounds, const PassSearchOptions& options) {
  PassSearch search(options);
  for (int i = 0; i < rounds * kPlaces; ++i) search.Add(Place(i % kPlaces));
  return search;
}

PassSearchOptions Apart(int models) {
  PassSearchOptions options;
  options.apart_models = models;
  return options;
}

TEST(PassSearch, NamesTheBestOfEachEarlierPass) {
  const PassSearch search = AfterRounds(2, Apart(8));
  const auto passes = search.BestOfEachPass(Place(10), search.size());
  ASSERT_EQ(passes.size(), 2u);
  for (const std::vector<int>& pass : passes) {
    ASSERT_FALSE(pass.empty());
    EXPECT_LE(pass.size(), 3u);
    EXPECT_EQ(pass.front() % kPlaces, 10);
    for (const int model : pass) EXPECT_EQ(model / kPlaces, pass.front() / kPlaces) << "one pass";
  }
  EXPECT_NE(passes[0].front(), passes[1].front());
}

TEST(PassSearch, WhatWasSeenAMomentAgoIsNoEarlierPass) {
  const PassSearch search = AfterRounds(1, Apart(8));
  for (const auto& pass : search.BestOfEachPass(Place(kPlaces - 1))) {
    for (const int model : pass) EXPECT_LT(model, kPlaces - 8);
  }
  EXPECT_TRUE(AfterRounds(1, Apart(kPlaces)).BestOfEachPass(Place(3)).empty());
}

TEST(PassSearch, NamesNothingForWhatWasNeverSeenOrShowsNothing) {
  const PassSearch search = AfterRounds(1, Apart(2));
  EXPECT_TRUE(search.BestOfEachPass(cv::Mat(5, 16, CV_32FC1, cv::Scalar(9))).empty());
  EXPECT_TRUE(search.BestOfEachPass(cv::Mat()).empty());
  PassSearchOptions none = Apart(2);
  none.passes = 0;
  EXPECT_TRUE(AfterRounds(2, none).BestOfEachPass(Place(3)).empty());
}

}  // namespace
}  // namespace gaitcam
