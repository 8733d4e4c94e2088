#include "results/reports/report_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/scoring/score_text.h"
#include "results/scoring/statistics.h"

namespace gaitcam::internal {
namespace {

using Eigen::Vector2d;

/// 1, 2 or 5 times a power of ten, not above a third of `width_m`.
double BarLength(double width_m) {
  const double max_m = width_m / 3, ten = std::pow(10, std::floor(std::log10(max_m)));
  for (const double length : {5 * ten, 2 * ten}) {
    if (length <= max_m) return length;
  }
  return ten;
}

std::string Bar(const FloorComparison& map) {
  const double width_m = map.cell_m * map.estimate.cols, bar_m = BarLength(width_m);
  const std::string label = bar_m >= 1 ? fmt::format("{:g} m", bar_m) : fmt::format("{:g} cm", 100 * bar_m);
  return fmt::format("<span class=\"bar\" style=\"width: {:.2f}%\"><span>{}</span></span>", 100 * bar_m / width_m,
                     label);
}

/// Pixel coordinates of the picture's outer edges: the first pixel's middle is (0.5, 0.5).
std::string Points(const FloorComparison& map, const std::vector<Vector2d>& piece) {
  std::string points;
  for (const Vector2d& p : piece) {
    const Vector2d at = (p - map.corner_m) / map.cell_m;
    points += fmt::format("{}{:.1f},{:.1f}", points.empty() ? "" : " ", at.x() + 0.5, 0.5 - at.y());
  }
  return points;
}

/// All halos lie below all lines, so that no path hides the other's colour.
std::string Paths(const FloorComparison& map, const PlanePath& truth, const PlanePath& estimate) {
  std::string halos, lines;
  const auto draw = [&](const PlanePath& path, const char* kind) {
    for (const std::vector<Vector2d>& piece : path) {
      const std::string points = Points(map, piece);
      halos += fmt::format("<polyline class=\"halo\" points=\"{}\"/>", points);
      lines += fmt::format("<polyline class=\"{}\" points=\"{}\"/>", kind, points);
    }
  };
  draw(truth, "true");
  draw(estimate, "path");
  return fmt::format("<svg viewBox=\"0 0 {} {}\" preserveAspectRatio=\"none\" aria-hidden=\"true\">{}{}</svg>",
                     map.estimate.cols, map.estimate.rows, halos, lines);
}

std::string Figure(const FloorComparison& map, const cv::Mat& picture, const std::string& name,
                   const std::string& caption, const std::string& over) {
  constexpr int kMaxPixels = 1200;
  return fmt::format(
      "<figure><div class=\"ground\" style=\"--aspect: {:.4f}\"><img alt=\"{}\" src=\"{}\">{}{}</div>"
      "<figcaption><b>{}</b> {}</figcaption></figure>\n",
      double(picture.cols) / picture.rows, Escape(name), JpegUri(picture, kMaxPixels), over, Bar(map), Escape(name),
      Escape(caption));
}

double Value(const FloorComparison& map, const std::string& name) {
  const auto score = std::find_if(map.scores.begin(), map.scores.end(), [&](const Score& s) { return s.name == name; });
  GAITCAM_ASSERT(score != map.scores.end());
  return score->value;
}

}  // namespace

PlanePath FloorPath(const Trajectory& trajectory, const FloorMotion& X_WV) {
  std::vector<double> gaps;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    gaps.push_back(double(trajectory[i].stamp_ns - trajectory[i - 1].stamp_ns));
  }
  const double longest = 2.5 * MedianOf(gaps);
  PlanePath path;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (i == 0 || gaps[i - 1] > longest) path.emplace_back();
    path.back().push_back(X_WV * trajectory[i].pose.translation.head<2>().eval());
  }
  return path;
}

std::string MapSection(const FloorComparison& map, const PlanePath& truth, const PlanePath& estimate) {
  const std::string paths = Paths(map, truth, estimate);
  std::string html = "<h2>The floor as it was mapped</h2>\n" +
                     Key({{"on-map-truth", "true path of the camera"}, {"on-map-path", "estimated path"}}, "") +
                     "<div class=\"maps\">\n";
  html += Figure(map, map.estimate, "Mapped",
                 fmt::format("{:g} mm per cell; the pictures' alignment moved it by {} mm", 1000 * map.cell_m,
                             ThreeDigits(1000 * Value(map, "map_shift_m"))),
                 paths);
  html += Figure(map, map.truth, "True", "the same ground without light and shade", paths);
  html += Figure(map, map.difference, "Difference",
                 "red where the map is too bright, blue where it is too dark, white where it is right; gain and offset "
                 "evened out",
                 "");
  html += Figure(map, map.mask, "Seen", "the brighter, the more often", "");
  return html + "</div>\n";
}

std::string MapCards(const FloorComparison& map) {
  return Card(
             "Map, correlation", Value(map, "map_ncc"), "",
             fmt::format("with the true floor over {} m\u00b2; 1 is perfect", ThreeDigits(Value(map, "map_area_m2")))) +
         Card("Map, geometry", 1000 * Value(map, "map_landmark_error_median_m"), "mm",
              fmt::format("median error of {:.0f} % of its {} landmarks; 90 % below {} mm",
                          100 * Value(map, "map_landmarks_found_ratio"), ScoreText(Value(map, "map_landmarks")),
                          ThreeDigits(1000 * Value(map, "map_landmark_error_p90_m"))));
}

}  // namespace gaitcam::internal

namespace gaitcam {

ReportSection FloorReportSection(const FloorComparison& map, const Trajectory& truth, const Trajectory& estimate) {
  if (map.empty()) return {};
  const FloorMotion X_WW = map.X_WV * map.X_WV_trajectory.Inverse();
  return {internal::MapCards(map),
          internal::MapSection(map, internal::FloorPath(truth, {}), internal::FloorPath(estimate, X_WW)),
          std::string(internal::PageFile("report_map.css"))};
}

}  // namespace gaitcam
