#include "results/reports/report_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "results/reports/ground_drawing.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/scoring/score_text.h"

namespace gaitcam::internal {
namespace {

using Eigen::Vector2d;

std::string Drawing(const PlaceGraphComparison& comparison, const PlaceGraph& graph) {
  std::vector<Vector2d> all = comparison.path_m;
  all.insert(all.end(), comparison.nodes_m.begin(), comparison.nodes_m.end());
  const GroundDrawing ground(all);
  std::string html = ground.Path(comparison.path_m);
  for (const PlaceLink& link : graph.links) {
    if (link.loop) continue;
    html += ground.Line(comparison.nodes_m[size_t(link.from)], comparison.nodes_m[size_t(link.to)], "link");
  }
  for (const Revisit& crossing : comparison.crossings) {
    html += ground.Circle(crossing.at_m, 3.2 * ground.unit(), crossing.found ? "ring" : "ring missed");
  }
  const double apart = 3.4 * ground.unit();  // of two numbers that can be read
  std::vector<Vector2d> numbered;
  for (size_t n = 0; n < comparison.nodes_m.size(); ++n) {
    const Vector2d& p = comparison.nodes_m[n];
    const auto covers = [&](const Vector2d& other) { return (other - p).norm() < apart; };
    const bool is_free = std::none_of(numbered.begin(), numbered.end(), covers);
    html += ground.Circle(p, (is_free ? 1.7 : 0.6) * ground.unit(), "node");
    if (!is_free) continue;
    numbered.push_back(p);
    html += fmt::format("<text x=\"{:.3f}\" y=\"{:.3f}\" font-size=\"{:.3f}\">{}</text>", ground.x(p), ground.y(p),
                        1.9 * ground.unit(), n);
  }
  for (const ClosedLoop& loop : comparison.loops) {
    html += ground.Line(loop.at_m, comparison.nodes_m[size_t(loop.to)], loop.right ? "right" : "wrong");
    html += ground.Circle(loop.at_m, 0.5 * ground.unit(), loop.right ? "right" : "wrong");
  }
  return ground.Svg(html, "map");
}

/// The panorama, and in it where the view was found.
cv::Mat WithWindow(const cv::Mat& panorama, const PlaceTest& test) {
  cv::Mat picture;
  cv::cvtColor(panorama, picture, cv::COLOR_GRAY2BGR);
  const int width = picture.cols;
  const int middle = int(std::lround(width * (0.5 - test.bearing_rad / (2 * std::numbers::pi))));
  for (const int turn : {-width, 0, width}) {
    cv::rectangle(picture, {middle + turn - test.view.cols / 2, 1},
                  {middle + turn + test.view.cols / 2, picture.rows - 2}, {60, 170, 20}, 3);
  }
  return picture;
}

/// A panorama as it would be from where the known one was made, its middle at `bearing_rad` there.
cv::Mat Turned(const cv::Mat& panorama, double bearing_rad) {
  const int width = panorama.cols, right = int(std::lround(-bearing_rad / (2 * std::numbers::pi) * width));
  const int cut = ((-right % width) + width) % width;  // column that comes to the left border
  if (cut == 0) return panorama;
  cv::Mat turned;
  cv::hconcat(panorama.colRange(cut, width), panorama.colRange(0, cut), turned);
  return turned;
}

/// Posterior of the events, "no loop" first (as the thesis's Figs. 4.12 and 4.13).
std::string Bars(const PlaceTest& test) {
  const size_t n = std::max<size_t>(1, test.posterior.size());
  std::string html = "<line x1=\"0\" y1=\"40\" x2=\"100\" y2=\"40\"/>";
  for (size_t i = 0; i < test.posterior.size(); ++i) {
    const double height = 38 * std::clamp(test.posterior[i], 0.0, 1.0);
    const char* kind = int(i) - 1 == test.matched ? "chosen" : i == 0 ? "none" : "";
    html += fmt::format(
        "<rect class=\"{}\" x=\"{:.3f}\" y=\"{:.3f}\" width=\"{:.3f}\" height=\"{:.3f}\"><title>{}: {:.3f}"
        "</title></rect>",
        kind, 100.0 * double(i) / double(n), 40 - height, 80.0 / double(n), height,
        i == 0 ? std::string("no loop") : fmt::format("place {}", i - 1), test.posterior[i]);
  }
  return "<svg viewBox=\"0 0 100 41\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"posterior\">" + html +
         "</svg>";
}

/// @param start_ns of the walk.
std::string LoopFigure(const ClosedLoop& loop, const PlaceTest& test, const PlaceGraph& graph, int64_t start_ns) {
  constexpr int kViewPixels = 240, kPanoramaPixels = 900;
  const cv::Mat& panorama = graph.nodes[size_t(loop.to)].panorama;
  const bool around = !panorama.empty() && test.view.cols == panorama.cols;
  std::string seen;
  if (around) {
    seen += fmt::format("<img class=\"panorama\" alt=\"seen all around\" src=\"{}\">",
                        JpegUri(Turned(test.view, test.bearing_rad), kPanoramaPixels));
  } else if (!test.view.empty()) {
    seen += fmt::format("<img alt=\"view\" src=\"{}\">", JpegUri(test.view, kViewPixels));
  }
  if (!panorama.empty()) {
    seen += fmt::format("<img class=\"panorama\" alt=\"panorama of place {}\" src=\"{}\">", loop.to,
                        JpegUri(around ? panorama : WithWindow(panorama, test), kPanoramaPixels));
  }
  const cv::Mat& place = graph.nodes[size_t(loop.to)].view;
  if (!place.empty()) seen += fmt::format("<img alt=\"place {}\" src=\"{}\">", loop.to, JpegUri(place, kViewPixels));
  std::string caption = "Left: the view; right: the place&rsquo;s panorama with the view&rsquo;s window";
  if (panorama.empty()) caption = "Left: the view; right: the place as it was seen";
  if (around) caption = "Above: what was seen all around, turned as it fits; then the place&rsquo;s panorama";
  const size_t chosen = size_t(test.matched + 1);
  if (chosen < test.posterior.size()) {
    caption += fmt::format(
        "; below: the posterior of &ldquo;no loop&rdquo; (grey) and of each place; the one that was matched has {:.2f}",
        test.posterior[chosen]);
  }
  return fmt::format(
      "<figure><div class=\"seen{}\">{}</div>{}<figcaption><b>{} place {}</b> at {:.1f} s, {:.2f} m from it. {}."
      "</figcaption></figure>\n",
      around ? " around" : "", seen, test.posterior.empty() ? "" : Bars(test),
      loop.right ? "Right:" : "False:", loop.to, double(loop.stamp_ns - start_ns) * 1e-9, loop.distance_m, caption);
}

/// The test that closed a loop.
const PlaceTest* DecidingTest(const PlaceGraph& graph, const ClosedLoop& loop) {
  const auto test = std::find_if(graph.tests.begin(), graph.tests.end(), [&](const PlaceTest& t) {
    return t.stamp_ns == loop.stamp_ns && t.matched == loop.to;
  });
  return test == graph.tests.end() ? nullptr : &*test;
}

double Value(const PlaceGraphComparison& comparison, const std::string& name) {
  const auto score =
      std::find_if(comparison.scores.begin(), comparison.scores.end(), [&](const Score& s) { return s.name == name; });
  GAITCAM_ASSERT(score != comparison.scores.end());
  return score->value;
}

}  // namespace

std::string PlaceSection(const PlaceGraphComparison& comparison, const PlaceGraph& graph) {
  constexpr size_t kMaxLoops = 8;
  std::string html = "<h2>Topological map</h2>\n" +
                     Key({{"truth", "true path"},
                          {"sim3", "places (numbered where there is room) and links between them"},
                          {"green", "right loop: from where the robot was to the place it recognised"},
                          {"bad", "false loop", "dashed"},
                          {"se3", "the path crosses itself; dashed ring: not noticed"}},
                         "") +
                     Drawing(comparison, graph);
  std::string figures;
  size_t count = 0;
  for (const ClosedLoop& loop : comparison.loops) {
    const PlaceTest* test = DecidingTest(graph, loop);
    if (!test || count++ >= kMaxLoops) continue;
    figures += LoopFigure(loop, *test, graph, comparison.start_ns);
  }
  if (figures.empty()) return html;
  const std::string first = count > kMaxLoops ? fmt::format(" (the first {} of {})", kMaxLoops, count) : "";
  html += fmt::format("<h2>What closed the loops{}</h2>\n<div class=\"loops\">\n{}</div>\n", first, figures);
  return html;
}

std::string PlaceCards(const PlaceGraphComparison& comparison, const PlaceGraph& graph) {
  const bool around = !graph.nodes.empty() && !graph.nodes.front().panorama.empty();
  const auto count = [&](const char* name) { return ScoreText(Value(comparison, name)); };
  return Card("Places", Value(comparison, "place_nodes"), "",
              fmt::format("{}{} bytes each", around ? "seen all around, " : "", count("place_node_bytes"))) +
         Card("Loops closed", Value(comparison, "loops_closed"), "",
              fmt::format("{} of them false; the path crosses itself {} times, {} noticed", count("loops_false"),
                          count("loop_crossings"), count("loop_crossings_found")));
}

}  // namespace gaitcam::internal

namespace gaitcam {

ReportSection PlaceReportSection(const PlaceGraphComparison& comparison, const PlaceGraph& graph) {
  return {internal::PlaceCards(comparison, graph), internal::PlaceSection(comparison, graph),
          std::string(internal::PageFile("report_graph.css"))};
}

}  // namespace gaitcam
