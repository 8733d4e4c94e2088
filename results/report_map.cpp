#include "results/report_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "results/html_page.h"
#include "results/statistics.h"

namespace gaitcam::internal {
namespace {

using Eigen::Vector2d;

constexpr std::string_view kStyle = R"css(
:root { --on-map-truth: #f0e442; --on-map-path: #38a8f0; }
.maps { display: grid; gap: .75rem; grid-template-columns: minmax(0, 1fr); }
@media (min-width: 760px) { .maps { grid-template-columns: repeat(2, minmax(0, 1fr)); } }
.maps figure { margin: 0; padding: .6rem; background: var(--card); border: 1px solid var(--line); border-radius: 12px; display: flex; flex-direction: column; }
.maps .ground { position: relative; margin: 0 auto; width: 100%; max-width: calc(560px * var(--aspect)); line-height: 0; border-radius: 6px; overflow: hidden; background: #000; }
.maps img { display: block; width: 100%; height: auto; }
.maps svg { position: absolute; inset: 0; width: 100%; height: 100%; }
.maps polyline, .maps circle { fill: none; stroke-linejoin: round; stroke-linecap: round; vector-effect: non-scaling-stroke; }
.maps .halo { stroke: rgba(0, 0, 0, .7); stroke-width: 5; }
.maps .true { stroke: var(--on-map-truth); stroke-width: 3.4; }
.maps .path { stroke: var(--on-map-path); stroke-width: 1.5; }
.maps .bar { position: absolute; left: .6rem; bottom: .6rem; min-width: 1px; border-bottom: 3px solid #fff; box-shadow: 0 1.5px 0 rgba(0, 0, 0, .75); }
.maps .bar span { position: absolute; left: 0; bottom: .3rem; white-space: nowrap; font-size: .75rem; line-height: 1.3; font-weight: 600; padding: 0 .35rem; border-radius: 4px; background: rgba(0, 0, 0, .62); color: #fff; }
.maps figcaption { padding: .5rem .2rem 0; font-size: .82rem; line-height: 1.4; color: var(--muted); }
.maps figcaption b { color: var(--ink); }
@media print { .maps { grid-template-columns: repeat(2, minmax(0, 1fr)); } .maps .ground { max-width: calc(330px * var(--aspect)); } }
)css";

/// 1, 2 or 5 times a power of ten, not above a third of `width_m`.
double BarLength(double width_m) {
  const double most = width_m / 3, ten = std::pow(10, std::floor(std::log10(most)));
  for (const double length : {5 * ten, 2 * ten}) {
    if (length <= most) return length;
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
  constexpr int kMostPixels = 1200;
  return fmt::format(
      "<figure><div class=\"ground\" style=\"--aspect: {:.4f}\"><img alt=\"{}\" src=\"{}\">{}{}</div>"
      "<figcaption><b>{}</b> {}</figcaption></figure>\n",
      double(picture.cols) / picture.rows, Escape(name), JpegUri(picture, kMostPixels), over, Bar(map), Escape(name),
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

std::string_view MapStyle() { return kStyle; }

}  // namespace gaitcam::internal
