/// Scores of localisation on a grid of reference places: the most similar reference of a view, the heading that
/// follows, and how peaked the similarity is (thesis, experiment 4.6).

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "results/scoring/score.h"

namespace gaitcam {

/// References on a grid: columns along +x, rows along +y, row by row.
struct PlaceGrid {
  int columns = 0, rows = 0;
  Eigen::Vector2d first_m{0, 0};  ///< Of the column and row 0.
  Eigen::Vector2d step_m{1, 1};   ///< > 0

  size_t size() const { return size_t(columns) * size_t(rows); }
  Eigen::Vector2d At(size_t index) const;
  /// The reference nearest to a point, which may lie beside the grid.
  size_t NearestTo(const Eigen::Vector2d& point_m) const;
  /// The same reference or one of its 8 neighbours.
  bool AreNeighbours(size_t a, size_t b) const;
};

/// A method's answer for one view: one value for each reference of the grid.
struct PlaceAnswer {
  std::vector<double> similarity;
  std::vector<double> bearing_rad;  ///< Heading of the view in each panorama.
};

/// Similarity between the references, interpolated bilinearly: CV_64FC1, row 0 at the greatest y, columns along +x,
/// `cells` pixels from one reference to the next, references at pixel centres. @pre cells >= 1, one value each.
cv::Mat SimilarityField(const PlaceGrid& grid, const std::vector<double>& similarity, int cells);

/// Where a field reaches a level.
struct FieldPeak {
  double area_ratio = 0;  ///< Share of the field's area.
  int modes = 0;          ///< Regions that do not touch each other, not even at a corner.
};
FieldPeak PeakAbove(const cv::Mat& field, double level);

/// One view by one method.
struct PlaceScore {
  size_t nearest = 0;            ///< Reference that truly is nearest ...
  size_t best = 0;               ///< ... and the one that is most similar, the first of equals.
  bool found = false;            ///< The best one is the nearest or a neighbour of it.
  double position_error_m = 0;   ///< From the best reference to where the view was taken.
  double bearing_error_deg = 0;  ///< [-180, 180]: heading by the best reference's panorama, less the true one.
  double similarity = 0;         ///< The best one.
  FieldPeak of_maximum;          ///< Where the field is above 90 % of its maximum. A method whose values are all alike
                                 ///< has a wide one, however right it is.
  FieldPeak of_range;            ///< Where it is above 90 % of the way from its minimum to its maximum.
};

/// @param heading_rad true heading of the view; @param reference_heading_rad of the middle of each reference's
/// panorama. @throws BadInput unless there is one value for each reference.
PlaceScore ScorePlace(const PlaceGrid& grid, const PlaceAnswer& answer, const Eigen::Vector2d& position_m,
                      double heading_rad, const std::vector<double>& reference_heading_rad);

/// All views of one condition by one method.
struct PlaceSummary {
  std::string method, condition;
  int queries = 0;
  double found_ratio = 0;
  double found_low = 0, found_high = 0;  ///< 95 % interval of the ratio (Wilson 1927).
  double position_error_median_m = 0;
  double bearing_error_median_deg = 0;  ///< Of the magnitude.
  double bearing_error_p90_deg = 0;
  double peak_area_ratio = 0;        ///< Mean of PlaceScore::of_maximum.area_ratio.
  double peak_area_range_ratio = 0;  ///< ... of of_range.area_ratio.
  double modes = 0;                  ///< ... of of_range.modes.
  double one_mode_ratio = 0;         ///< Share of views with a single one.
};
/// @pre not empty.
PlaceSummary Summarise(const std::string& method, const std::string& condition, const std::vector<PlaceScore>& scores);

/// What a method costs.
struct PlaceMethodCost {
  std::string method;
  double bytes_per_place = 0;
  double add_ms = 0;    ///< Median over the references: a panorama's signature.
  double query_ms = 0;  ///< Median over the views: a view's signature, compared with all references.
  double query_p95_ms = 0;
};

/// Named scores of all methods and conditions: `wavelet_plain_found_ratio`, ...; bytes among them, times apart.
Scores PlaceScores(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods);

}  // namespace gaitcam
