#include "algorithms/planes/floor_map.h"

#include <gtest/gtest.h>

#include <vector>

namespace gaitcam {
namespace {

TEST(FloorMap, ACellHoldsTheMeanOfItsSightings) {
  FloorMap map(0.01);
  EXPECT_FALSE(map.At({0, 0}).has_value());
  map.Add({0.001, 0.001}, 10);
  map.Add({0.009, 0.009}, 30);
  map.Add({-0.001, 0.001}, 200);  // the neighbour across zero
  EXPECT_FLOAT_EQ(*map.At({0.005, 0.005}), 20);
  EXPECT_FLOAT_EQ(*map.At({-0.005, 0.005}), 200);
  EXPECT_EQ(map.Sightings({0.005, 0.005}), 2);
  EXPECT_EQ(map.Sightings({3, 3}), 0);
}

TEST(FloorMap, BetweenCellCentresIsBilinearAndNeedsAllFour) {
  FloorMap map(1.0);
  for (int y = -2; y < 3; ++y) {
    for (int x = -2; x < 3; ++x) map.Add({x + 0.5, y + 0.5}, float(10 * x + 3 * y + 100));  // a plane
  }
  EXPECT_NEAR(*map.Between({0.7, 1.1}), 10 * 0.2 + 3 * 0.6 + 100, 1e-4);
  EXPECT_NEAR(*map.Between({-0.7, -0.9}), 10 * -1.2 + 3 * -1.4 + 100, 1e-4);
  EXPECT_FALSE(map.Between({2.6, 0.5}).has_value());
}

TEST(FloorMap, CopiesShareWhatNoneOfThemHasWrittenSince) {
  FloorMap first(0.005);
  for (double x = 0; x < 2; x += 0.005) {
    for (double y = 0; y < 2; y += 0.02) first.Add({x, y}, 100);
  }
  const size_t alone = first.own_bytes();
  std::vector<FloorMap> copies(100, first);
  EXPECT_EQ(copies[0].own_bytes(), 0U);
  copies[0].Add({1, 1}, 0);
  EXPECT_EQ(copies[0].own_bytes() * copies[0].tiles(), alone);  // one tile
  EXPECT_FLOAT_EQ(*first.At({1, 1}), 100);
  EXPECT_LT(*copies[0].At({1, 1}), 100);
  double all = first.shared_bytes();
  for (const FloorMap& copy : copies) all += copy.shared_bytes();
  EXPECT_NEAR(all, double(alone + copies[0].own_bytes()), 1);
}

TEST(FloorMap, ThePictureStandsAsOneLooksDownOnTheFloor) {
  FloorMap map(0.01);
  map.Add({0.055, 0.025}, 250);
  const FloorPicture picture = map.Draw();
  const int column = int(std::lround((0.055 - picture.corner_m.x()) / 0.01));
  const int row = int(std::lround((picture.corner_m.y() - 0.025) / 0.01));
  EXPECT_EQ(picture.intensity.at<uchar>(row, column), 250);
  EXPECT_EQ(picture.sightings.at<uint16_t>(row, column), 1);
  EXPECT_EQ(cv::countNonZero(picture.intensity), 1);
  EXPECT_TRUE(FloorMap(0.01).Draw().intensity.empty());
}

TEST(FloorMap, ACellSeenVeryOftenKeepsItsMean) {
  FloorMap map(0.01);
  for (int i = 0; i < 200000; ++i) map.Add({0, 0}, 77);
  EXPECT_NEAR(*map.At({0, 0}), 77, 0.1);
}

}  // namespace
}  // namespace gaitcam
