/// The page that tells a run: self-contained HTML that opens from disk, for a browser or a printer.
///
/// Charts are drawn by Debian's packaged Chart.js, which is inlined when the page is written; pictures are inlined as
/// well. Only the film stays a file of its own, beside the page.

#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/place_graph.h"
#include "algorithms/core/trajectory.h"
#include "results/floor_score.h"
#include "results/place_graph_score.h"
#include "results/score.h"

namespace gaitcam {

/// Gait and blur of one frame, as far as it is known.
struct ReportFrame {
  int64_t stamp_ns = 0;
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;  ///< How far image points moved during the exposure.
  TrackingStatus status = TrackingStatus::kInitializing;
  bool restarted = false;
  int features = 0, inliers = 0;
  bool has_gait = false;  ///< The four fields below are set.
  bool left_contact = false, right_contact = false;
  int step = -1;     ///< Index of the step; -1 while standing.
  double phase = 0;  ///< 0..1 within it.
};

/// A frame as it was exposed, and one sharp instant of the same frame.
struct ReportTwin {
  int64_t stamp_ns = 0;
  cv::Mat blurred, sharp;  ///< CV_8UC1 or CV_8UC3 (BGR), any size.
  double blur_median_px = 0;
  double blur_max_px = 0;
};

enum class RunEnd { kFinished, kFell, kInterrupted };

struct ReportInput {
  std::string title;     ///< The scenario's name.
  std::string subtitle;  ///< One line: robot, place, gait, camera, system.
  RunEnd end = RunEnd::kFinished;
  double end_time_s = 0;  ///< When it ended, on the simulation's clock.
  std::string renderer;   ///< As EGL names it.
  bool software_renderer = false;
  double min_good_coverage_ratio = 0.8;  ///< Below it a banner warns.

  const Scores* scores = nullptr;  ///< Null if there was too little to score; then `no_scores_reason` says why.
  std::string no_scores_reason;
  const FloorComparison* map = nullptr;          ///< Of a system that maps the floor; else null.
  const PlaceGraph* graph = nullptr;             ///< Of a system that makes a topological map; else null ...
  const PlaceGraphComparison* places = nullptr;  ///< ... as is what it is worth.
  Trajectory truth;                              ///< Poses X_WC of the camera.
  std::vector<ReportFrame> frames;               ///< One per frame, in order.
  std::vector<ReportTwin> twins;                 ///< About 8 of them.

  std::string video_file;         ///< Relative to the page, such as "walk.mp4"; "" if there is none.
  cv::Mat video_poster;           ///< Shown until the film plays; may be empty.
  std::string resolved_scenario;  ///< YAML text.
  std::vector<std::pair<std::string, std::string>> facts;  ///< Name and value: seed, versions, command, exposure, ...
};

struct ReportOptions {
  std::filesystem::path chart_library;  ///< chart.min.js; empty looks in Debian's places.
};

/// The page as text.
/// @throws MissingResource naming the Debian package if Chart.js is not there.
std::string ReportHtml(const ReportInput& input, const ReportOptions& options = {});

/// Writes the page to `path`, under a temporary name first.
/// @throws MissingResource as above, or if the file cannot be written.
void WriteReport(const std::filesystem::path& path, const ReportInput& input, const ReportOptions& options = {});

}  // namespace gaitcam
