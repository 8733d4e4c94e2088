/// The report of a run: one self-contained HTML page, for a browser or a printer.
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
#include "algorithms/core/frame_truth.h"
#include "algorithms/core/trajectory.h"
#include "results/reports/report_section.h"
#include "results/scoring/score.h"

namespace gaitcam {

/// One frame: what is true of it, and what the system said of it.
struct ReportFrame : FrameTruth {
  TrackingStatus status = TrackingStatus::kInitializing;  ///< Finally,
  TrackingStatus live = TrackingStatus::kInitializing;    ///< and when the frame was answered; as above if not known.
  bool restarted = false;
  int features = 0, inliers = 0;
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
  std::string subtitle;  ///< One line: robot, scene, gait, camera, system.
  RunEnd end = RunEnd::kFinished;
  double end_time_s = 0;  ///< When it ended, on the simulation's clock.
  std::string renderer;   ///< Who rendered, in one line.
  bool software_renderer = false;
  double min_good_coverage_ratio = 0.8;  ///< Below it a banner warns.

  const Scores* scores = nullptr;  ///< Null if there was too little to score; then `no_scores_reason` says why.
  std::string no_scores_reason;
  std::vector<ReportSection> sections;  ///< Of maps, in the order in which they are to stand.
  Trajectory truth;                     ///< Poses X_WC of the camera.
  std::vector<ReportFrame> frames;      ///< One per frame, in order.
  std::vector<ReportTwin> twins;        ///< About 8 of them.

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

/// Writes the page to `path`, whole or not at all (WriteWholeFile).
/// @throws MissingResource as above, or if the file cannot be written.
void WriteReport(const std::filesystem::path& path, const ReportInput& input, const ReportOptions& options = {});

}  // namespace gaitcam
