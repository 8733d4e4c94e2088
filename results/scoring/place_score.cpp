#include "results/scoring/place_score.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

constexpr double kPeakLevel = 0.9;
constexpr int kFieldCells = 10;  ///< From one reference to the next; finer changes no area by a hundredth.

/// Wilson's score interval of a ratio, at 95 %.
std::pair<double, double> WilsonInterval(double ratio, double n) {
  const double z = 1.959964, zz = z * z;
  const double middle = (ratio + zz / (2 * n)) / (1 + zz / n);
  const double half = z / (1 + zz / n) * std::sqrt(ratio * (1 - ratio) / n + zz / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

/// @param name ends with "_" and stands before each: "wavelet_plain_".
std::vector<Metric<PlaceSummary>> SummaryMetrics(const std::string& name) {
  constexpr ScoreGroup kGroup = ScoreGroup::kLoops;
  return {{name + "found_ratio", "", Better::kHigher, kGroup, "most similar place is the nearest or a neighbour of it",
           [](const auto& s) { return s.found_ratio; }, true},
          {name + "bearing_error_median_deg", "deg", Better::kLower, kGroup, "of the heading by the most similar place",
           [](const auto& s) { return s.bearing_error_median_deg; }, true},
          {name + "position_error_median_m", "m", Better::kLower, kGroup, "from the most similar place to the view",
           [](const auto& s) { return s.position_error_median_m; }},
          {name + "peak_area_ratio", "", Better::kLower, kGroup,
           "of the field above 90 % of the greatest similarity, mean", [](const auto& s) { return s.peak_area_ratio; }},
          {name + "peak_area_range_ratio", "", Better::kLower, kGroup,
           "of the field above 90 % of the range of similarity, mean",
           [](const auto& s) { return s.peak_area_range_ratio; }},
          {name + "modes", "", Better::kNearOne, kGroup, "separate regions of that area, mean",
           [](const auto& s) { return s.modes; }},
          {name + "one_mode_ratio", "", Better::kHigher, kGroup, "views with one such region alone",
           [](const auto& s) { return s.one_mode_ratio; }}};
}

std::vector<Metric<PlaceMethodCost>> MemoryMetrics(const std::string& method) {
  return {{method + "_bytes_per_place", "bytes", Better::kLower, ScoreGroup::kLoops, "to store a place",
           [](const auto& m) { return m.bytes_per_place; }}};
}

std::vector<Metric<PlaceMethodCost>> TimeMetrics(const std::string& method) {
  constexpr ScoreGroup kGroup = ScoreGroup::kTiming;
  return {{method + "_add_ms_median", "ms", Better::kLower, kGroup, "signature of a panorama",
           [](const auto& m) { return m.add_ms; }},
          {method + "_query_ms_median", "ms", Better::kLower, kGroup, "one view against all places",
           [](const auto& m) { return m.query_ms; }},
          {method + "_query_ms_p95", "ms", Better::kLower, kGroup, "likewise",
           [](const auto& m) { return m.query_p95_ms; }}};
}

void Append(const std::vector<Score>& more, std::vector<Score>& scores) {
  scores.insert(scores.end(), more.begin(), more.end());
}

}  // namespace

Eigen::Vector2d PlaceGrid::At(size_t index) const {
  GAITCAM_ASSERT(index < size());
  const Eigen::Vector2d cell(double(index % size_t(columns)), double(index / size_t(columns)));
  return first_m + cell.cwiseProduct(step_m);
}

size_t PlaceGrid::NearestTo(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d cell = (point_m - first_m).cwiseQuotient(step_m);
  const int column = std::clamp(int(std::lround(cell.x())), 0, columns - 1);
  const int row = std::clamp(int(std::lround(cell.y())), 0, rows - 1);
  return size_t(row) * size_t(columns) + size_t(column);
}

bool PlaceGrid::AreNeighbours(size_t a, size_t b) const {
  const int across = int(a % size_t(columns)) - int(b % size_t(columns));
  const int along = int(a / size_t(columns)) - int(b / size_t(columns));
  return std::abs(across) <= 1 && std::abs(along) <= 1;
}

cv::Mat SimilarityField(const PlaceGrid& grid, const std::vector<double>& similarity, int cells) {
  GAITCAM_ASSERT(similarity.size() == grid.size() && cells >= 1);
  cv::Mat field((grid.rows - 1) * cells + 1, (grid.columns - 1) * cells + 1, CV_64FC1);
  for (int v = 0; v < field.rows; ++v) {
    const int up = field.rows - 1 - v, row = std::min(up / cells, std::max(0, grid.rows - 2));
    const double b = double(up) / cells - row;
    for (int u = 0; u < field.cols; ++u) {
      const int column = std::min(u / cells, std::max(0, grid.columns - 2));
      const double a = double(u) / cells - column;
      const auto at = [&](int c, int r) {
        return similarity[size_t(std::min(r, grid.rows - 1) * grid.columns + std::min(c, grid.columns - 1))];
      };
      field.at<double>(v, u) = (1 - b) * ((1 - a) * at(column, row) + a * at(column + 1, row)) +
                               b * ((1 - a) * at(column, row + 1) + a * at(column + 1, row + 1));
    }
  }
  return field;
}

FieldPeak PeakAbove(const cv::Mat& field, double level) {
  const cv::Mat above = field >= level;
  cv::Mat labels;
  const int regions = cv::connectedComponents(above, labels, 8) - 1;
  return {double(cv::countNonZero(above)) / double(above.total()), regions};
}

PlaceScore ScorePlace(const PlaceGrid& grid, const PlaceAnswer& answer, const Eigen::Vector2d& position_m,
                      double heading_rad, const std::vector<double>& reference_heading_rad) {
  for (const std::vector<double>* values : {&answer.similarity, &answer.bearing_rad, &reference_heading_rad}) {
    if (values->size() != grid.size()) {
      throw BadInput("places: " + std::to_string(values->size()) + " values for " + std::to_string(grid.size()) +
                     " references; there must be one for each");
    }
  }
  PlaceScore score;
  score.nearest = grid.NearestTo(position_m);
  score.best = size_t(std::max_element(answer.similarity.begin(), answer.similarity.end()) - answer.similarity.begin());
  score.found = grid.AreNeighbours(score.nearest, score.best);
  score.similarity = answer.similarity[score.best];
  score.position_error_m = (grid.At(score.best) - position_m).norm();
  const double error = reference_heading_rad[score.best] + answer.bearing_rad[score.best] - heading_rad;
  score.bearing_error_deg = std::remainder(error, 2 * kPi) * 180 / kPi;
  const cv::Mat field = SimilarityField(grid, answer.similarity, kFieldCells);
  double low = 0, high = 0;
  cv::minMaxLoc(field, &low, &high);
  score.of_maximum = PeakAbove(field, kPeakLevel * high);
  score.of_range = PeakAbove(field, low + kPeakLevel * (high - low));
  return score;
}

PlaceSummary Summarise(const std::string& method, const std::string& condition, const std::vector<PlaceScore>& scores) {
  GAITCAM_ASSERT(!scores.empty());
  PlaceSummary summary{method, condition, int(scores.size())};
  std::vector<double> positions, bearings;
  for (const PlaceScore& s : scores) {
    positions.push_back(s.position_error_m);
    bearings.push_back(std::abs(s.bearing_error_deg));
    summary.found_ratio += s.found;
    summary.peak_area_ratio += s.of_maximum.area_ratio;
    summary.peak_area_range_ratio += s.of_range.area_ratio;
    summary.modes += s.of_range.modes;
    summary.one_mode_ratio += s.of_range.modes == 1;
  }
  for (double* mean : {&summary.found_ratio, &summary.peak_area_ratio, &summary.peak_area_range_ratio, &summary.modes,
                       &summary.one_mode_ratio})
    *mean /= double(scores.size());
  std::tie(summary.found_low, summary.found_high) = WilsonInterval(summary.found_ratio, double(scores.size()));
  summary.position_error_median_m = MedianOf(positions);
  summary.bearing_error_median_deg = MedianOf(bearings);
  summary.bearing_error_p90_deg = QuantileOf(bearings, 0.9);
  return summary;
}

Scores PlaceScores(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods) {
  Scores scores;
  for (const PlaceSummary& s : summaries) {
    Append(Evaluate(SummaryMetrics(s.method + "_" + s.condition + "_"), s), scores.scores);
  }
  for (const PlaceMethodCost& m : methods) {
    Append(Evaluate(MemoryMetrics(m.method), m), scores.scores);
    Append(Evaluate(TimeMetrics(m.method), m), scores.timing);
  }
  return scores;
}

}  // namespace gaitcam
