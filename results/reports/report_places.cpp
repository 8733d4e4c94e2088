#include "results/reports/report_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;
using internal::Banner;
using internal::Card;
using internal::Escape;
using internal::JpegUri;
using internal::ThreeDigits;

const std::vector<std::string> kColours{"sim3", "se3", "green", "purple", "truth", "muted"};

const PlaceSummary* Find(const std::vector<PlaceSummary>& summaries, const std::string& method,
                         const std::string& condition) {
  for (const PlaceSummary& s : summaries) {
    if (s.method == method && s.condition == condition) return &s;
  }
  return nullptr;
}

std::vector<std::string> ConditionsOf(const std::vector<PlaceSummary>& summaries) {
  std::vector<std::string> conditions;
  for (const PlaceSummary& s : summaries) {
    if (std::find(conditions.begin(), conditions.end(), s.condition) == conditions.end())
      conditions.push_back(s.condition);
  }
  return conditions;
}

// ---- Heat maps

/// Colours of the thesis's Fig. 4.8.
cv::Mat Coloured(const cv::Mat& field, double low, double high) {
  cv::Mat bytes, colours;
  field.convertTo(bytes, CV_8U, high > low ? 255 / (high - low) : 0, high > low ? -low * 255 / (high - low) : 0);
  cv::applyColorMap(bytes, colours, cv::COLORMAP_JET);
  return colours;
}

void Cross(cv::Mat& map, const cv::Point2d& at) {
  constexpr int kArm = 9;
  for (const auto& [colour, width] : {std::pair(cv::Scalar(0, 0, 0), 5), std::pair(cv::Scalar(255, 255, 255), 2)}) {
    for (const int sign : {1, -1}) {
      cv::line(map, cv::Point(at) - cv::Point(kArm, sign * kArm), cv::Point(at) + cv::Point(kArm, sign * kArm), colour,
               width, cv::LINE_AA);
    }
  }
}

cv::Mat Bar(int height, double low, double high) {
  constexpr int kWidth = 64, kColour = 16, kLeft = 8;
  cv::Mat bar(height, kWidth, CV_8UC3, cv::Scalar(255, 255, 255)), ramp(height, kColour, CV_64FC1);
  for (int v = 0; v < height; ++v) ramp.row(v).setTo(high - (high - low) * v / std::max(1, height - 1));
  Coloured(ramp, low, high).copyTo(bar(cv::Rect(kLeft, 0, kColour, height)));
  for (const double share : {0.0, 0.5, 1.0}) {
    const std::string text = ThreeDigits(high - share * (high - low));
    cv::putText(bar, text, {kLeft + kColour + 3, 10 + int(share * (height - 13))}, cv::FONT_HERSHEY_SIMPLEX, 0.36,
                cv::Scalar(60, 60, 60), 1, cv::LINE_AA);
  }
  return bar;
}

// ---- The page

std::string Header(const PlaceReportInput& input) {
  const bool whole = input.status == "finished";
  return fmt::format(
      "<header>\n<span class=\"brand\">gaitcam run: places</span>\n<h1>{}</h1>\n<span class=\"pill {}\">{}</span>\n"
      "<p>{}</p>\n</header>\n",
      Escape(input.title), whole ? "good" : "warn", whole ? "&#10003; finished" : "&#9632; interrupted",
      Escape(input.subtitle));
}

std::string Banners(const PlaceReportInput& input) {
  std::string html;
  if (input.status != "finished")
    html += Banner("warn", "The run was interrupted.", "Conditions that are missing below were not filmed.");
  if (input.software_renderer) {
    html += Banner(
        "warn", "Rendered in software.",
        "Pictures may differ in single grey levels from those of a graphics processor. Renderer: " + input.renderer);
  }
  return html;
}

std::string Cards(const PlaceReportInput& input) {
  std::string html = "<dl class=\"cards\">\n";
  const PlaceMethodCost& first = input.methods.front();
  if (const PlaceSummary* plain = Find(input.summaries, first.method, "plain")) {
    html += Card("Found, " + first.method, 100 * plain->found_ratio, "%",
                 fmt::format("of {} views: the most similar place is the nearest or next to it", plain->queries));
    html += Card("Bearing error", plain->bearing_error_median_deg, "\u00b0",
                 "median; 90 % below " + ThreeDigits(plain->bearing_error_p90_deg) + "\u00b0");
  }
  html += Card("A place takes", first.bytes_per_place, "bytes", "by " + first.method);
  html += Card("A question takes", first.query_ms, "ms", "median: one view against all places");
  return html + "</dl>\n";
}

std::string Percent(double ratio) { return fmt::format("{:.1f}", 100 * ratio); }

/// A row per method, a column per condition.
std::string Matrix(const PlaceReportInput& input, const std::vector<std::string>& conditions, bool greatest_is_best,
                   const auto& value_of, const auto& text_of) {
  std::string html = "<section class=\"panel scroll places\"><table><thead><tr><th>method</th>";
  for (const std::string& c : conditions) html += "<th>" + Escape(c) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const PlaceMethodCost& method : input.methods) {
    html += "<tr><td><code>" + Escape(method.method) + "</code></td>";
    for (const std::string& condition : conditions) {
      const PlaceSummary* own = Find(input.summaries, method.method, condition);
      bool best = own != nullptr;
      for (const PlaceSummary& s : input.summaries) {
        if (!best || s.condition != condition) continue;
        best = greatest_is_best ? value_of(s) <= value_of(*own) : value_of(s) >= value_of(*own);
      }
      html += fmt::format("<td class=\"number{}\">{}</td>", best ? " best" : "", own ? text_of(*own) : "&ndash;");
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string FoundSection(const PlaceReportInput& input, const std::vector<std::string>& conditions) {
  std::string html =
      "<h2>Found</h2>\n<p class=\"note\">Share of views, in percent, whose most similar place is the "
      "nearest one or one of its eight neighbours, with its 95 % interval.</p>\n";
  std::vector<internal::KeyEntry> key;
  for (size_t m = 0; m < input.methods.size(); ++m) {
    const std::string& name = input.methods[m].method;
    key.push_back({kColours[m % kColours.size()], name, "area", name});
  }
  html += internal::Panel("found", "Views that were found", key, 260);
  html += Matrix(
      input, conditions, true, [](const PlaceSummary& s) { return s.found_ratio; },
      [](const PlaceSummary& s) {
        return fmt::format("{} <small>{:.0f}&ndash;{:.0f}</small>", Percent(s.found_ratio), 100 * s.found_low,
                           100 * s.found_high);
      });
  html += "<dl class=\"facts\" style=\"margin-top: .75rem\">\n";
  for (const auto& [name, text] : input.conditions)
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", Escape(name), Escape(text));
  return html + "</dl>\n";
}

std::string BearingSection(const PlaceReportInput& input, const std::vector<std::string>& conditions) {
  return "<h2>Bearing</h2>\n<p class=\"note\">Error of the heading that follows from where the view lies in the most "
         "similar panorama, median in degrees over all views, wrong places included; small: 90 % are below.</p>\n" +
         Matrix(
             input, conditions, false, [](const PlaceSummary& s) { return s.bearing_error_median_deg; },
             [](const PlaceSummary& s) {
               return fmt::format("{:.1f} <small>{:.0f}</small>", s.bearing_error_median_deg, s.bearing_error_p90_deg);
             });
}

std::string PeakSection(const PlaceReportInput& input, const std::vector<std::string>& conditions) {
  std::string html =
      "<h2>How clearly</h2>\n<p class=\"note\">Share of the field, in percent, where the interpolated similarity is "
      "above 90 % of its maximum; small: above 90 % of the way from its minimum to its maximum, and into how many "
      "separate regions that area falls on average. It says how sharp a peak is, not whether it is in the right "
      "place.</p>\n";
  return html + Matrix(
                    input, conditions, false, [](const PlaceSummary& s) { return s.peak_area_ratio; },
                    [](const PlaceSummary& s) {
                      return fmt::format("{} <small>{}, {:.2f}</small>", Percent(s.peak_area_ratio),
                                         Percent(s.peak_area_range_ratio), s.modes);
                    });
}

std::string CostSection(const PlaceReportInput& input) {
  std::string html =
      "<h2>Cost</h2>\n<p class=\"note\">Times differ from run to run; everything else on this page does not.</p>\n"
      "<section class=\"panel scroll places\"><table><thead><tr><th>method</th><th>bytes per place</th><th>signature "
      "of a panorama, ms</th><th>view against all places, ms</th><th>95 % below, ms</th></tr></thead><tbody>\n";
  for (const PlaceMethodCost& m : input.methods) {
    html += fmt::format(
        "<tr><td><code>{}</code></td><td class=\"number\">{:.0f}</td><td class=\"number\">{}</td><td "
        "class=\"number\">{}</td><td class=\"number\">{}</td></tr>\n",
        Escape(m.method), m.bytes_per_place, ThreeDigits(m.add_ms), ThreeDigits(m.query_ms),
        ThreeDigits(m.query_p95_ms));
  }
  return html + "</tbody></table></section>\n";
}

/// The panorama with the window where the view lies; a window over the seam is drawn on both sides.
cv::Mat WithWindow(const PlaceExample& example) {
  cv::Mat picture;
  cv::cvtColor(example.panorama, picture, cv::COLOR_GRAY2BGR);
  const double width = picture.cols;
  for (const double turn : {-width, 0.0, width}) {
    const cv::Point corner(int(std::lround(example.window_left_px + turn)), 1);
    cv::rectangle(picture, corner, corner + cv::Point(int(example.window_width_px), picture.rows - 3),
                  cv::Scalar(60, 200, 255), 2);
  }
  return picture;
}

std::string ExampleSection(const PlaceExample& example) {
  std::string html = "<section class=\"panel example\"><h3>" + Escape(example.title) + "</h3>\n<div class=\"seen\">";
  html += fmt::format("<figure><img alt=\"the view\" src=\"{}\"><figcaption>the view</figcaption></figure>",
                      JpegUri(example.image, 416));
  html += fmt::format(
      "<figure><img alt=\"the most similar panorama\" src=\"{}\"><figcaption>the panorama that is most similar by {}, "
      "and where the view lies in it</figcaption></figure></div>\n<div class=\"fields\">",
      JpegUri(WithWindow(example), 1024), Escape(example.methods.front()));
  for (size_t m = 0; m < example.methods.size(); ++m) {
    const PlaceScore& s = example.scores[m];
    html += fmt::format(
        "<figure><img alt=\"similarity by {0}\" src=\"{1}\"><figcaption><b>{0}</b> {2}; {3} m off, bearing {4:+.1f}"
        "&deg;; {5} % of the field above 90 % of the maximum</figcaption></figure>",
        Escape(example.methods[m]), JpegUri(example.maps[m], 800), s.found ? "found" : "not found",
        ThreeDigits(s.position_error_m), s.bearing_error_deg, ThreeDigits(100 * s.of_maximum.area_ratio));
  }
  return html + "</div></section>\n";
}

std::string ChartData(const PlaceReportInput& input, const std::vector<std::string>& conditions) {
  Json json;
  json["conditions"] = conditions;
  json["methods"] = Json::array();
  for (size_t m = 0; m < input.methods.size(); ++m) {
    Json method{{"name", input.methods[m].method}, {"colour", kColours[m % kColours.size()]}};
    method["found"] = Json::array();
    for (const std::string& condition : conditions) {
      const PlaceSummary* s = Find(input.summaries, input.methods[m].method, condition);
      method["found"].push_back(s ? Json(std::round(1000 * s->found_ratio) / 10) : Json(nullptr));
    }
    json["methods"].push_back(method);
  }
  return json.dump();
}

}  // namespace

cv::Mat HeatMap(const PlaceGrid& grid, const std::vector<double>& similarity, const Eigen::Vector2d& position_m,
                int width_px) {
  constexpr int kCells = 10, kBorder = 14;
  const cv::Mat field = SimilarityField(grid, similarity, kCells);
  double low = 0, high = 0;
  cv::minMaxLoc(field, &low, &high);
  const double px_per_m = (width_px - 2 * kBorder) / (grid.step_m.x() * std::max(1, grid.columns - 1));
  const cv::Size size(width_px - 2 * kBorder,
                      std::max(1, int(std::lround(px_per_m * grid.step_m.y() * (grid.rows - 1)))));
  cv::Mat large;
  cv::resize(field, large, size, 0, 0, cv::INTER_LINEAR);
  cv::Mat map;
  // Beyond the outermost references, where views may lie, the field goes on as it is at its edge.
  cv::copyMakeBorder(Coloured(large, low, high), map, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  const auto pixel = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d m = p - grid.first_m;
    return cv::Point2d(kBorder + px_per_m * m.x(), kBorder + size.height - px_per_m * m.y());
  };
  for (size_t i = 0; i < grid.size(); ++i) cv::circle(map, pixel(grid.At(i)), 1, cv::Scalar(0, 0, 0), -1, cv::LINE_AA);
  const size_t best = size_t(std::max_element(similarity.begin(), similarity.end()) - similarity.begin());
  cv::circle(map, pixel(grid.At(best)), 10, cv::Scalar(0, 0, 0), 2, cv::LINE_AA);
  Cross(map, pixel(position_m));
  cv::Mat whole;
  cv::hconcat(map, Bar(map.rows, low, high), whole);
  return whole;
}

std::string PlaceReportHtml(const PlaceReportInput& input, const std::filesystem::path& chart_library) {
  GAITCAM_ASSERT(!input.methods.empty());
  const std::vector<std::string> conditions = ConditionsOf(input.summaries);
  internal::HtmlPage page;
  page.title = input.title;
  page.body = Header(input) + Banners(input) + Cards(input) + FoundSection(input, conditions) +
              BearingSection(input, conditions) + PeakSection(input, conditions) + CostSection(input);
  if (!input.examples.empty()) {
    page.body +=
        "<h2>Similarity over the field</h2>\n<p class=\"note\">Blue where it is least, dark red where it is greatest. "
        "Cross: where the view was taken; ring: the most similar place; dots: the places. The first views as they "
        "came.</p>\n";
  }
  for (const PlaceExample& example : input.examples) page.body += ExampleSection(example);
  std::vector<std::pair<std::string, std::string>> facts = input.facts;
  if (!input.renderer.empty()) facts.emplace_back("renderer", input.renderer);
  page.body += "<h2>Run</h2>\n" + internal::Facts(facts) +
               "<section class=\"panel\"><details><summary>Scenario, with all defaults</summary><pre>" +
               Escape(input.resolved_scenario) + "</pre></details></section>\n";
  page.data = ChartData(input, conditions);
  page.style = internal::PageFile("localisation.css");
  page.script = internal::PageFile("localisation.js");
  return internal::PageHtml(page, chart_library);
}

std::string PlaceTable(const std::vector<PlaceSummary>& summaries, const std::vector<PlaceMethodCost>& methods) {
  const std::vector<std::string> conditions = ConditionsOf(summaries);
  size_t width = 6;
  for (const std::string& c : conditions) width = std::max(width, c.size());
  std::string text = fmt::format("{:<{}}", "found, % (bearing, deg)", width + 10);
  for (const PlaceMethodCost& m : methods) text += fmt::format("  {:>14}", m.method);
  for (const std::string& condition : conditions) {
    text += fmt::format("\n{:<{}}", condition, width + 10);
    for (const PlaceMethodCost& m : methods) {
      const PlaceSummary* s = Find(summaries, m.method, condition);
      const std::string cell =
          s ? fmt::format("{:.1f} ({:.1f})", 100 * s->found_ratio, s->bearing_error_median_deg) : "-";
      text += fmt::format("  {:>14}", cell);
    }
  }
  const auto row = [&](const char* name, const auto& value) {
    text += fmt::format("\n{:<{}}", name, width + 10);
    for (const PlaceMethodCost& m : methods) text += fmt::format("  {:>14}", value(m));
  };
  const auto plain = [&](const PlaceMethodCost& m) { return Find(summaries, m.method, "plain"); };
  row("field above 90 %, %",
      [&](const auto& m) { return plain(m) ? fmt::format("{:.1f}", 100 * plain(m)->peak_area_ratio) : "-"; });
  row("modes", [&](const auto& m) { return plain(m) ? fmt::format("{:.2f}", plain(m)->modes) : "-"; });
  row("bytes per place", [](const auto& m) { return fmt::format("{:.0f}", m.bytes_per_place); });
  row("ms per query", [](const auto& m) { return ThreeDigits(m.query_ms); });
  return text + "\n";
}

}  // namespace gaitcam
