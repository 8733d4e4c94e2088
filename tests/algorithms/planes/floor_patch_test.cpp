#include "algorithms/planes/floor_patch.h"

#include <gtest/gtest.h>

#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

Pose Rolled(const PlanarPose& below) { return CameraOver(below, kDrawnHeight_m, kDrawnPitch_rad, 0.05); }

FloorPatch PatchOf(const DrawnFloor& floor, const Pose& X_WC) {
  const cv::Mat image = Draw(floor, {X_WC});
  return FloorPatch::Of(ImagePyramid::Of(image, 3), cv::Mat(image.size(), CV_8UC1, cv::Scalar(255)), SmallCamera(),
                        X_WC, 0.005, 0.8, 300);
}

TEST(FloorPatch, ShowsTheFloorAsSeenFromAbove) {
  const DrawnFloor floor(1);
  const Pose X_WC = Rolled({{0.4, -0.3}, 1.1});
  const PlanarPose below = BelowCamera(X_WC);
  const FloorPatch patch = PatchOf(floor, X_WC);
  double sum2 = 0;
  int count = 0;
  for (double x = 0; x < 0.8; x += 0.01) {
    for (double y = -0.4; y < 0.4; y += 0.01) {
      const auto sample = patch.levels[0].At({x, y});
      if (!sample) continue;
      sum2 += std::pow(sample->intensity - floor.At(below * Eigen::Vector2d(x, y)), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  EXPECT_LT(std::sqrt(sum2 / count), 6);  // of a contrast of some 50: pixels far ahead are 1 cm long
}

TEST(FloorPatch, SlopesAreThoseOfItsIntensities) {
  const FloorPatch patch = PatchOf(DrawnFloor(1), Rolled({}));
  const Eigen::Vector2d p = patch.levels[0].match.front().p + Eigen::Vector2d(0.001, 0.0013);
  constexpr double kStep_m = 1e-4;
  const auto at = [&](double dx, double dy) {
    return double(patch.levels[0].At(p + Eigen::Vector2d(dx, dy))->intensity);
  };
  EXPECT_NEAR(patch.levels[0].At(p)->slope.x(), (at(kStep_m, 0) - at(-kStep_m, 0)) / (2 * kStep_m), 1);
  EXPECT_NEAR(patch.levels[0].At(p)->slope.y(), (at(0, kStep_m) - at(0, -kStep_m)) / (2 * kStep_m), 1);
}

TEST(FloorPatch, OnlyTheMaskIsSeen) {
  const Pose X_WC = CameraOver({});
  const cv::Mat image = Draw(DrawnFloor(1), {X_WC});
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(0));
  const auto of = [&] {
    return FloorPatch::Of(ImagePyramid::Of(image, 3), mask, SmallCamera(), X_WC, 0.005, 0.8, 300);
  };
  EXPECT_TRUE(of().empty());
  mask.colRange(0, mask.cols / 2).setTo(255);  // the left half: y > 0
  const FloorPatch left = of();
  EXPECT_FALSE(left.empty());
  for (const FloorPatch::Point& point : left.levels[0].match) EXPECT_GT(point.p.y(), -0.005);
}

TEST(DrawFloor, SeveralPatchesMakeOnePictureOfTheTrueFloor) {
  const DrawnFloor floor(2);
  std::vector<FloorPatch> patches;
  std::vector<PlanarPose> poses;
  for (int i = 0; i < 6; ++i) {
    const Pose X_WC = Rolled({{0.1 * i, 0.02 * i}, 0.1 * i});
    poses.push_back(BelowCamera(X_WC));
    patches.push_back(PatchOf(floor, X_WC));
  }
  const FloorPicture picture = DrawFloor(patches, poses, 0.005);
  ASSERT_FALSE(picture.empty());
  double sum2 = 0;
  int count = 0;
  for (int row = 0; row < picture.intensity.rows; ++row) {
    for (int column = 0; column < picture.intensity.cols; ++column) {
      if (picture.sightings.at<uint16_t>(row, column) < 3) continue;
      const Eigen::Vector2d p = picture.corner_m + picture.cell_m * Eigen::Vector2d(column, -row);
      sum2 += std::pow(picture.intensity.at<uchar>(row, column) - floor.At(p), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_LT(std::sqrt(sum2 / count), 6);
  EXPECT_TRUE(DrawFloor({}, {}, 0.005).empty());
}

}  // namespace
}  // namespace gaitcam
