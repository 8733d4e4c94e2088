/// The page of a localisation: which method finds which views, and how clearly.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "results/place_score.h"
#include "results/score.h"

namespace gaitcam {

/// What a method costs.
struct PlaceMethodCost {
  std::string method;
  double bytes_per_place = 0;
  double add_ms = 0;    ///< Median over the references: a panorama's signature.
  double query_ms = 0;  ///< Median over the views: a view's signature, compared with all references.
  double query_p95_ms = 0;
};

/// A view as the page shows it, with what two methods make of it.
struct PlaceExample {
  std::string title;                               ///< "plain, view 3"
  cv::Mat image;                                   ///< As filmed.
  cv::Mat panorama;                                ///< The first method's best reference.
  double window_left_px = 0, window_width_px = 0;  ///< Where in it the view lies; may reach round the seam.
  std::vector<std::string> methods;
  std::vector<PlaceScore> scores;  ///< Of each method.
  std::vector<cv::Mat> maps;       ///< HeatMap of each method.
};

struct PlaceReportInput {
  std::string title, subtitle;
  std::string status = "finished";  ///< Or "interrupted".
  std::string renderer;
  bool software_renderer = false;
  std::vector<std::pair<std::string, std::string>> conditions;  ///< Name and what it is.
  std::vector<PlaceMethodCost> methods;
  std::vector<PlaceSummary> summaries;  ///< Of each method and condition.
  std::vector<PlaceExample> examples;
  std::string resolved_scenario;
  std::vector<std::pair<std::string, std::string>> facts;
};

/// A similarity field in colours, blue where it is least and dark red where it is greatest, with a white cross where
/// the view was taken, dots at the references, a ring about the best one, and a bar that says values. CV_8UC3.
cv::Mat HeatMap(const PlaceGrid& grid, const std::vector<double>& similarity, const Eigen::Vector2d& position_m,
                int width_px);

/// @throws MissingResource if Chart.js is not there.
std::string PlaceReportHtml(const PlaceReportInput& input, const std::filesystem::path& chart_library = {});

/// Named scores of all methods and conditions: `wavelet_plain_found_ratio`, ...; bytes among them, times apart.
Scores PlaceScores(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods);

/// Methods by conditions for a terminal.
std::string PlaceTable(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods);

}  // namespace gaitcam
