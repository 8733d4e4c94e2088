/// The report of a localisation experiment: success, error and peakedness of each method.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "results/scoring/place_score.h"

namespace gaitcam {

/// A view shown on the page, with the answers of two methods.
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
  std::string renderer;             ///< Who rendered, in one line.
  bool software_renderer = false;
  std::vector<std::pair<std::string, std::string>> conditions;  ///< Name and what it is.
  std::vector<PlaceMethodCost> methods;
  std::vector<PlaceSummary> summaries;  ///< Of each method and condition.
  std::vector<PlaceExample> examples;
  std::string resolved_scenario;
  std::vector<std::pair<std::string, std::string>> facts;
};

/// A similarity field in colours, blue where it is least and dark red where it is greatest, with a white cross where
/// the view was taken, dots at the references, a ring about the best one, and a colour bar. CV_8UC3.
cv::Mat HeatMap(const PlaceGrid& grid, const std::vector<double>& similarity, const Eigen::Vector2d& position_m,
                int width_px);

/// @throws MissingResource if Chart.js is not there.
std::string PlaceReportHtml(const PlaceReportInput& input, const std::filesystem::path& chart_library = {});

/// Methods by conditions for a terminal.
std::string PlaceTable(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods);

}  // namespace gaitcam
