#include "algorithms/planes/floor_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gaitcam {
namespace {

/// A cell's own value: bilinear at its centre needs the neighbours towards +x and +y too.
float MeanAt(const FloorMap& map, double x, double y) {
  const FloorPicture picture = map.Draw();
  const int column = int(std::lround((x - picture.corner_m.x()) / map.cell_m()));
  const int row = int(std::lround((picture.corner_m.y() - y) / map.cell_m()));
  return picture.intensity.at<uchar>(row, column);
}

TEST(FloorMap, ACellHoldsTheMeanOfItsSightings) {
  FloorMap map(0.01);
  map.Add({0.001, 0.001}, 10);
  map.Add({0.009, 0.009}, 30);
  map.Add({-0.001, 0.001}, 200);  // the neighbour across zero
  EXPECT_EQ(MeanAt(map, 0.005, 0.005), 20);
  EXPECT_EQ(MeanAt(map, -0.005, 0.005), 200);
  EXPECT_EQ(map.Sightings({0.005, 0.005}), 2);
  EXPECT_EQ(map.Sightings({3, 3}), 0);
}

/// Cells of 1 m over a plane: 10 per metre along x, 3 along y.
FloorMap Plane(int from, int to, uint16_t when) {
  FloorMap map(1.0);
  for (int y = from; y < to; ++y) {
    for (int x = from; x < to; ++x) map.Add({x + 0.5, y + 0.5}, float(x + 0.3 * y + 100), when);
  }
  return map;
}

TEST(FloorMap, BetweenCellCentresIsBilinearAndNeedsAllFour) {
  const FloorMap map = Plane(-70, 70, 0);  // over several tiles
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.7, 1.1), {-0.7, -0.9}, {63.9, -64.2}, {64.3, 63.7}}) {
    const auto sample = map.At(p);
    ASSERT_TRUE(sample.has_value());
    EXPECT_NEAR(sample->intensity, (p.x() - 0.5) + 0.3 * (p.y() - 0.5) + 100, 0.01);  // 1/256 grey and floats
    EXPECT_NEAR(sample->dx, 1, 0.01);
    EXPECT_NEAR(sample->dy, 0.3, 0.01);
  }
  EXPECT_FALSE(map.At({69.9, 0.5}).has_value());
  EXPECT_FALSE(FloorMap(1.0).At({0, 0}).has_value());
}

TEST(FloorMap, WhatWasSeenFirstTooLateIsLeftOut) {
  FloorMap map = Plane(-3, 3, 5);
  map.Add({0.5, 0.5}, 90, 9);  // seen again: its first time stays
  EXPECT_TRUE(map.At({1.0, 1.0}, 5).has_value());
  EXPECT_FALSE(map.At({1.0, 1.0}, 4).has_value());
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
  EXPECT_EQ(MeanAt(first, 1.0025, 1.0025), 100);
  EXPECT_LT(MeanAt(copies[0], 1.0025, 1.0025), 100);
  double all = first.shared_bytes();
  for (const FloorMap& copy : copies) all += copy.shared_bytes();
  EXPECT_GE(all, double(alone + copies[0].own_bytes()));
  EXPECT_LT(all, 2 * double(alone));  // and 102 directories
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
  for (int i = 0; i < 2000; ++i) map.Add({0, 0}, 77);
  EXPECT_EQ(MeanAt(map, 0.005, 0.005), 77);
}

}  // namespace
}  // namespace gaitcam
