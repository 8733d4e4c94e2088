#include "results/scoring/place_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// 5 x 4 references half a metre apart, the first at (-1, -0.75).
PlaceGrid Grid() { return {5, 4, {-1, -0.75}, {0.5, 0.5}}; }

/// A hill of this width about a point, on `base`.
std::vector<double> Hill(const PlaceGrid& grid, const Vector2d& top, double width_m, double base = 0) {
  std::vector<double> values;
  for (size_t i = 0; i < grid.size(); ++i)
    values.push_back(base + std::exp(-0.5 * (grid.At(i) - top).squaredNorm() / (width_m * width_m)));
  return values;
}

PlaceAnswer AnswerOf(std::vector<double> similarity, double bearing_rad = 0) {
  const size_t n = similarity.size();
  return {std::move(similarity), std::vector<double>(n, bearing_rad)};
}

TEST(PlaceGrid, PointsBelongToTheNearestReferenceAlsoBesideTheGrid) {
  const PlaceGrid grid = Grid();
  for (size_t i = 0; i < grid.size(); ++i) EXPECT_EQ(grid.NearestTo(grid.At(i) + Vector2d(0.24, -0.24)), i);
  EXPECT_EQ(grid.NearestTo({-9, -9}), 0U);
  EXPECT_EQ(grid.NearestTo({9, 9}), grid.size() - 1);
}

TEST(PlaceGrid, NeighboursAreEightAndDoNotReachRoundTheEdge) {
  const PlaceGrid grid = Grid();
  const auto neighbours = [&](size_t of) {
    int count = 0;
    for (size_t i = 0; i < grid.size(); ++i) count += grid.AreNeighbours(of, i);
    return count;
  };
  EXPECT_EQ(neighbours(0), 4);             // itself and three
  EXPECT_EQ(neighbours(6), 9);             // second column of the second row
  EXPECT_EQ(neighbours(5), 6);             // first column: itself and five
  EXPECT_FALSE(grid.AreNeighbours(4, 5));  // end of a row and start of the next
}

TEST(SimilarityField, GoesThroughTheReferencesAndStraightBetweenThem) {
  const PlaceGrid grid = Grid();
  std::vector<double> plane;
  for (size_t i = 0; i < grid.size(); ++i) plane.push_back(2 * grid.At(i).x() + 3 * grid.At(i).y());
  const cv::Mat field = SimilarityField(grid, plane, 4);
  ASSERT_EQ(field.size(), cv::Size(17, 13));
  for (int v = 0; v < field.rows; ++v) {
    for (int u = 0; u < field.cols; ++u) {
      const double x = -1 + 0.125 * u, y = -0.75 + 0.125 * (12 - v);  // row 0 is the greatest y
      EXPECT_NEAR(field.at<double>(v, u), 2 * x + 3 * y, 1e-12);
    }
  }
}

TEST(SimilarityField, OfASingleRowOrReferenceIsALineOrAPoint) {
  EXPECT_EQ(SimilarityField({3, 1, {0, 0}, {1, 1}}, {1, 2, 3}, 10).size(), cv::Size(21, 1));
  EXPECT_EQ(SimilarityField({1, 1, {0, 0}, {1, 1}}, {7}, 10).at<double>(0, 0), 7);
}

TEST(PeakAbove, CountsAreaAndRegions) {
  cv::Mat field(10, 20, CV_64FC1, cv::Scalar(0));
  field(cv::Rect(1, 1, 4, 5)).setTo(1);
  field(cv::Rect(5, 6, 2, 2)).setTo(1);  // touches at a corner: the same region
  field(cv::Rect(15, 1, 4, 4)).setTo(0.95);
  EXPECT_DOUBLE_EQ(PeakAbove(field, 0.9).area_ratio, (20 + 4 + 16) / 200.0);
  EXPECT_EQ(PeakAbove(field, 0.9).modes, 2);
  EXPECT_EQ(PeakAbove(field, 0.99).modes, 1);
  EXPECT_EQ(PeakAbove(field, 2).modes, 0);
  EXPECT_EQ(PeakAbove(field, 0).area_ratio, 1);
}

TEST(ScorePlace, KnowsAHillThatStandsWhereTheViewIs) {
  const PlaceGrid grid = Grid();
  const Vector2d here = grid.At(7) + Vector2d(0.1, 0.05);
  const std::vector<double> headings(grid.size(), 0.2);
  const PlaceScore score = ScorePlace(grid, AnswerOf(Hill(grid, here, 0.4), 0.5), here, 0.7 - 2 * kPi, headings);
  EXPECT_EQ(score.nearest, 7U);
  EXPECT_EQ(score.best, 7U);
  EXPECT_TRUE(score.found);
  EXPECT_NEAR(score.position_error_m, std::hypot(0.1, 0.05), 1e-12);
  EXPECT_NEAR(score.bearing_error_deg, 0, 1e-9);  // 0.2 + 0.5 is the true heading, a turn away
  EXPECT_EQ(score.of_range.modes, 1);
}

TEST(ScorePlace, ANeighbourIsFoundAndTheNextOneIsNot) {
  const PlaceGrid grid = Grid();
  const std::vector<double> headings(grid.size(), 0);
  const auto found = [&](size_t best) {
    return ScorePlace(grid, AnswerOf(Hill(grid, grid.At(best), 0.3)), grid.At(6), 0, headings).found;
  };
  EXPECT_TRUE(found(12));  // one to the right, one up
  EXPECT_FALSE(found(8));  // two to the right
}

TEST(ScorePlace, ABearingErrorIsTheShorterWayRoundAndSigned) {
  const PlaceGrid grid = Grid();
  const std::vector<double> headings(grid.size(), 0);
  const PlaceAnswer answer = AnswerOf(Hill(grid, {0, 0}, 0.3), 170 * kPi / 180);
  EXPECT_NEAR(ScorePlace(grid, answer, {0, 0}, -170 * kPi / 180, headings).bearing_error_deg, -20, 1e-9);
  EXPECT_NEAR(ScorePlace(grid, answer, {0, 0}, 160 * kPi / 180, headings).bearing_error_deg, 10, 1e-9);
}

TEST(ScorePlace, WiderHillsHaveWiderPeaksAndTwoHillsAreTwoModes) {
  const PlaceGrid grid{13, 9, {-2.4, -1.6}, {0.4, 0.4}};
  const std::vector<double> headings(grid.size(), 0);
  const auto peak = [&](const std::vector<double>& values) {
    return ScorePlace(grid, AnswerOf(values), {0, 0}, 0, headings);
  };
  // A Gaussian hill is above 90 % of its height within 0.459 widths: an ellipse of known area. Fine, as straight lines
  // between references cut a hill's top.
  const PlaceGrid fine{49, 33, {-2.4, -1.6}, {0.1, 0.1}};
  const double field_m2 = 4.8 * 3.2, radius = std::sqrt(-2 * std::log(0.9));
  const PlaceScore hill =
      ScorePlace(fine, AnswerOf(Hill(fine, {0, 0}, 1.5)), {0, 0}, 0, std::vector<double>(fine.size(), 0));
  EXPECT_NEAR(hill.of_maximum.area_ratio, kPi * std::pow(1.5 * radius, 2) / field_m2, 0.002);
  EXPECT_LT(peak(Hill(grid, {0, 0}, 0.5)).of_maximum.area_ratio, peak(Hill(grid, {0, 0}, 1)).of_maximum.area_ratio);
  std::vector<double> two = Hill(grid, {-1.6, 0}, 0.5);
  const std::vector<double> other = Hill(grid, {1.6, 0.8}, 0.5);
  for (size_t i = 0; i < two.size(); ++i) two[i] += 0.97 * other[i];
  EXPECT_EQ(peak(two).of_range.modes, 2);
}

TEST(ScorePlace, ValuesThatAreAllAlikeHaveAWidePeakByTheirMaximumButNotByTheirRange) {
  const PlaceGrid grid{13, 9, {-2.4, -1.6}, {0.4, 0.4}};
  const PlaceScore score =
      ScorePlace(grid, AnswerOf(Hill(grid, {0, 0}, 0.5, 100)), {0, 0}, 0, std::vector<double>(grid.size(), 0));
  EXPECT_EQ(score.of_maximum.area_ratio, 1);
  EXPECT_LT(score.of_range.area_ratio, 0.05);
}

TEST(ScorePlace, RefusesAnswersOfAnotherGrid) {
  const PlaceGrid grid = Grid();
  EXPECT_THROW(ScorePlace(grid, AnswerOf({1, 2, 3}), {0, 0}, 0, std::vector<double>(grid.size(), 0)), BadInput);
}

TEST(Summarise, IsOfTheMagnitudesAndHasAnInterval) {
  std::vector<PlaceScore> scores(100);
  for (size_t i = 0; i < scores.size(); ++i) {
    scores[i].found = i < 90;
    scores[i].bearing_error_deg = i % 2 ? 3.0 : -3.0;
    scores[i].position_error_m = double(i);
    scores[i].of_range = {0.1, i < 80 ? 1 : 3};
  }
  const PlaceSummary summary = Summarise("wavelet", "plain", scores);
  EXPECT_EQ(summary.queries, 100);
  EXPECT_NEAR(summary.found_ratio, 0.9, 1e-12);
  EXPECT_NEAR(summary.found_low, 0.8256, 1e-4);  // Wilson's interval of 90 of 100
  EXPECT_NEAR(summary.found_high, 0.9448, 1e-4);
  EXPECT_NEAR(summary.bearing_error_median_deg, 3, 1e-12);
  EXPECT_NEAR(summary.position_error_median_m, 49.5, 1e-12);
  EXPECT_NEAR(summary.modes, 1.4, 1e-12);
  EXPECT_NEAR(summary.one_mode_ratio, 0.8, 1e-12);
}

}  // namespace
}  // namespace gaitcam
