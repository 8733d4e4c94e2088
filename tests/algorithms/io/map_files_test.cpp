// Maps of landmarks and occupancy grids come back from disk, and wrong files are told where they are wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/landmark_map_file.h"
#include "algorithms/io/occupancy_grid_file.h"
#include "tests/algorithms/io/file_test.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

class MapFiles : public FileTest {
 protected:
  std::string ErrorOf(const std::string& name, const std::string& text) {
    const std::filesystem::path file = Write(name, text);
    try {
      if (name.ends_with(".csv")) ReadLandmarkMap(file);
      if (name.ends_with(".yaml")) ReadOccupancyGrid(file);
    } catch (const BadInput& e) {
      return e.what();
    }
    return "nothing was thrown";
  }
};

LandmarkMap SomeLandmarks() {
  LandmarkMap map;
  MapPoint bare, known, floats;
  bare.id = 7;
  bare.p_W = {0.1, -1.0 / 3, 1e-12};
  known.id = std::numeric_limits<int64_t>::max();
  known.p_W = {1e5, 2, -3};
  Eigen::Matrix3d root;
  root << 0.1, 0, 0, 0.02, 0.3, 0, -0.01, 0.07, 1e-3;
  known.covariance = root * root.transpose();
  known.covariance->triangularView<Eigen::StrictlyLower>() = known.covariance->transpose();
  known.descriptor = (cv::Mat_<uchar>(1, 4) << 0, 255, 16, 1);
  floats.id = -2;
  floats.descriptor = (cv::Mat_<float>(1, 3) << 0.1F, -3e-20F, 17.0F);
  map.points = {bare, known, floats};
  return map;
}

TEST_F(MapFiles, LandmarksComeBackToTheBit) {
  WriteLandmarkMap(folder_ / "landmarks.csv", SomeLandmarks());
  const LandmarkMap read = ReadLandmarkMap(folder_ / "landmarks.csv");
  ASSERT_EQ(read.points.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const MapPoint expected = SomeLandmarks().points[i], &point = read.points[i];
    EXPECT_EQ(point.id, expected.id);
    EXPECT_EQ(point.p_W, expected.p_W);
    EXPECT_EQ(point.covariance, expected.covariance);
    ASSERT_EQ(point.descriptor.size(), expected.descriptor.size());
    if (expected.descriptor.empty()) continue;
    EXPECT_EQ(point.descriptor.type(), expected.descriptor.type());
    EXPECT_EQ(cv::norm(point.descriptor, expected.descriptor, cv::NORM_INF), 0);
  }
}

TEST_F(MapFiles, AWrongTableOfLandmarksIsToldWhere) {
  EXPECT_THAT(ErrorOf("a.csv", "#id\n1,0,0,0,,,,,,,\n1,0,0,0,,,,,,,\n"), HasSubstr("a.csv:3: the id 1 stands twice"));
  EXPECT_THAT(ErrorOf("b.csv", "1,0,zero,0,,,,,,,\n"), HasSubstr("b.csv:1: \"zero\" is not a finite number"));
  EXPECT_THAT(ErrorOf("c.csv", "1,0,0,0,1,0,0,1,0,,\n"), HasSubstr("field 10 should be a covariance"));
  EXPECT_THAT(ErrorOf("d.csv", "1,0,0,0,,,,,,,f32:00\n"), HasSubstr("expected a multiple of 8"));
  EXPECT_THAT(ErrorOf("e.csv", "1,0,0,0,,,,,,,u8:0g\n"), HasSubstr("no hexadecimal digit"));
  EXPECT_THAT(ErrorOf("f.csv", "1,0,0\n"), HasSubstr("the row ends after 3 fields"));
}

OccupancyGrid SomeGrid() {
  OccupancyGrid grid;
  grid.cell_m = 0.05;
  grid.corner_m = {-1.2, 3.4};
  grid.log_odds = cv::Mat::zeros(3, 4, CV_32FC1);
  grid.log_odds.at<float>(0, 0) = 2;
  grid.log_odds.at<float>(1, 3) = -2;
  grid.log_odds.at<float>(2, 1) = 40;
  return grid;
}

TEST_F(MapFiles, AGridComesBackToItsEightBits) {
  WriteOccupancyGrid(folder_ / "grid.yaml", SomeGrid());
  const OccupancyGrid read = ReadOccupancyGrid(folder_ / "grid.yaml"), expected = SomeGrid();
  EXPECT_EQ(read.cell_m, expected.cell_m);
  EXPECT_NEAR((read.corner_m - expected.corner_m).norm(), 0, 1e-12);
  ASSERT_EQ(read.log_odds.size(), expected.log_odds.size());
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 4; ++col) {
      const float was = expected.log_odds.at<float>(row, col), is = read.log_odds.at<float>(row, col);
      EXPECT_NEAR(OccupancyGrid::Probability(is), OccupancyGrid::Probability(was), 1.0 / 510 + 1e-6);
      if (was == 0) {
        EXPECT_EQ(is, 0);
      }
    }
  }
}

// map_server: the origin is the lower left corner of the lower left pixel; occupied is black.
TEST_F(MapFiles, AGridLiesAsMapServerReadsIt) {
  WriteOccupancyGrid(folder_ / "grid.yaml", SomeGrid());
  const std::string text = ReadText(folder_ / "grid.yaml");
  EXPECT_THAT(text, HasSubstr("image: grid.png\nresolution: 0.05\n"));
  double x = 0, y = 0;
  ASSERT_EQ(std::sscanf(text.c_str() + text.find("origin: ["), "origin: [%lf, %lf", &x, &y), 2);
  EXPECT_NEAR(x, -1.225, 1e-12);
  EXPECT_NEAR(y, 3.4 + 0.025 - 3 * 0.05, 1e-12);
  const cv::Mat image = ReadImage(folder_ / "grid.png", "");
  EXPECT_EQ(image.at<uchar>(0, 0), 30);  // 255 (1 - 1 / (1 + exp(-2)))
  EXPECT_EQ(image.at<uchar>(2, 1), 0);
  EXPECT_EQ(image.at<uchar>(1, 1), 128);
}

TEST_F(MapFiles, AWrongGridIsToldWhere) {
  WriteOccupancyGrid(folder_ / "grid.yaml", SomeGrid());
  EXPECT_THAT(ErrorOf("a.yaml", "image: grid.png\nresolution: 0\norigin: [0, 0, 0]\nnegate: 0\n"),
              HasSubstr("a.yaml:2: resolution: expected a side above 0 m"));
  EXPECT_THAT(ErrorOf("b.yaml", "image: grid.png\nresolution: 1\norigin: [0, 0, 1]\nnegate: 0\n"),
              HasSubstr("b.yaml:3: origin: expected yaw 0"));
  EXPECT_THAT(ErrorOf("c.yaml", "image: none.png\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\n"),
              HasSubstr("none.png: cannot read this file"));
  EXPECT_THAT(ErrorOf("d.yaml", "image: grid.png\norigin: [0, 0, 0]\n"), HasSubstr("the key resolution is missing"));
}

TEST_F(MapFiles, WhereNothingCanBeWrittenAResourceIsMissing) {
  EXPECT_THROW(WriteLandmarkMap("/proc/nowhere/landmarks.csv", SomeLandmarks()), MissingResource);
  EXPECT_THROW(WriteOccupancyGrid("/proc/nowhere/grid.yaml", SomeGrid()), MissingResource);
}

}  // namespace
}  // namespace gaitcam
