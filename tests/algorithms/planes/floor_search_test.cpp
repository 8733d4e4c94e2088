#include "algorithms/planes/floor_search.h"

#include <gtest/gtest.h>

#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

constexpr double kCell_m = 0.025;

/// The part of a floor about `corner` in coordinates that X_MS maps into the floor's. Every seventh cell is unknown.
FloorPicture PictureOf(const DrawnFloor& floor, const Eigen::Vector2d& corner, int cols, int rows,
                       const PlanarPose& X_MS = {}, double gain = 1, double offset = 0) {
  FloorPicture picture;
  picture.cell_m = kCell_m;
  picture.corner_m = corner;
  picture.intensity.create(rows, cols, CV_8UC1);
  picture.sightings.create(rows, cols, CV_16UC1);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      const Eigen::Vector2d p = corner + kCell_m * Eigen::Vector2d(x, -y);
      const bool seen = (x + 3 * y) % 7 != 0;
      picture.intensity.at<uchar>(y, x) = seen ? cv::saturate_cast<uchar>(gain * floor.At(X_MS * p) + offset) : 0;
      picture.sightings.at<uint16_t>(y, x) = seen;
    }
  }
  return picture;
}

TEST(FloorSearch, FindsASubmapThatIsFarShiftedAndRotated) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const DrawnFloor floor(seed);
    RandomStream random(seed, "test");
    const FloorPicture map = PictureOf(floor, {-1.5, 1.2}, 120, 100);
    const PlanarPose truth({random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4)}, random.Uniform(-0.3, 0.3));
    const FloorPicture submap = PictureOf(floor, {-0.3, 0.25}, 28, 22, truth, 0.8, 12);
    FloorSearchRange range;
    range.reach_rad = 0.35;
    const std::vector<FloorFind> finds = SearchFloor(map, submap, range, 150, 3);
    ASSERT_FALSE(finds.empty()) << seed;
    const Eigen::Vector2d middle(0.04, -0.01);
    EXPECT_LT((finds.front().X_MS * middle - truth * middle).norm(), 1.5 * kCell_m) << seed;
    EXPECT_LT(std::abs(finds.front().X_MS.heading - truth.heading), range.step_rad) << seed;
    EXPECT_GT(finds.front().correlation, 0.85) << seed;
    for (size_t i = 1; i < finds.size(); ++i) EXPECT_LE(finds[i].correlation, finds.front().correlation);
  }
}

TEST(FloorSearch, ASubmapBeyondTheMapsEdgeIsFoundByTheCommonCells) {
  const DrawnFloor floor(5);
  const FloorPicture map = PictureOf(floor, {-1, 1}, 80, 80);
  const PlanarPose truth({-0.9, 0.1}, 0);  // a third of it lies outside
  const FloorPicture submap = PictureOf(floor, {-0.35, 0.3}, 28, 24, truth);
  FloorSearchRange range;
  range.reach_m = 1.2;
  const std::vector<FloorFind> finds = SearchFloor(map, submap, range, 150, 3);
  ASSERT_FALSE(finds.empty());
  EXPECT_LT((finds.front().X_MS.position - truth.position).norm(), kCell_m);
}

TEST(FloorSearch, KeepsToItsRangeAndFindsNothingOnAFloorWithoutTexture) {
  const DrawnFloor floor(6);
  const FloorPicture map = PictureOf(floor, {-1.5, 1.2}, 120, 100);
  const PlanarPose truth({0.6, 0}, 0);
  const FloorPicture submap = PictureOf(floor, {-0.3, 0.25}, 28, 22, truth);
  FloorSearchRange range;
  range.reach_m = 0.2;
  for (const FloorFind& find : SearchFloor(map, submap, range, 150, 6)) {
    EXPECT_LT((find.X_MS * Eigen::Vector2d(0.04, -0.01) - Eigen::Vector2d(0.04, -0.01)).norm(), 0.25);
  }
  range.reach_m = 1;
  EXPECT_TRUE(SearchFloor(map, PictureOf(floor, {0, 0}, 28, 22, {}, 0, 90), range, 150, 6).empty());
  EXPECT_TRUE(SearchFloor({}, submap, range, 150, 6).empty());
}

}  // namespace
}  // namespace gaitcam
