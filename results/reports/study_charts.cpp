#include "results/reports/study_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace gaitcam::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSeriesColours[] = {"sim3", "se3", "green", "purple", "truth", "muted"};
constexpr size_t kMaxPoints = 1500;  ///< Of one series of a scatter plot.
constexpr size_t kMaxCells = 400;    ///< Of all heat maps of one score.

Json Significant(double value) { return std::isfinite(value) ? Json(std::stod(fmt::format("{:.5g}", value))) : Json(); }

/// "position error after Sim(3) alignment, root mean square, m".
std::string AxisTitle(const Score& metric) {
  std::string text = metric.name == "coverage_ratio" ? "part of frames with a pose" : metric.meaning;
  if (text.size() > 36) return metric.name;  // units are in names, too
  return metric.unit.empty() ? text : text + ", " + (metric.unit == "deg" ? "°" : metric.unit);
}

/// Which runs belong together.
using Levels = std::vector<std::pair<size_t, size_t>>;  // axis, level

std::vector<const StudyRun*> RunsAt(const StudyTable& table, const Levels& levels) {
  std::vector<const StudyRun*> runs;
  for (const StudyRun& run : table.runs) {
    if (std::all_of(levels.begin(), levels.end(), [&](const auto& l) { return run.levels[l.first] == l.second; }))
      runs.push_back(&run);
  }
  return runs;
}

/// Over the runs at these levels.
MedianRow MedianAt(const StudyReportInput& input, const Levels& levels, const std::string& score) {
  std::string label = "page";
  for (const auto& [axis, level] : levels) label += fmt::format("/{}={}", axis, level);
  return SummarizeRuns(RunsAt(*input.table, levels), score, input.statistics, label);
}

/// The series of charts: the levels of `by`, or one of all runs.
struct Series {
  std::string name, colour;
  Levels levels;
};

std::vector<Series> SeriesOf(const StudyReportInput& input, size_t axis) {
  if (!input.by || *input.by == axis) return {{"all runs", "sim3", {}}};
  std::vector<Series> series;
  for (const std::string& level : input.table->axes[*input.by].levels) {
    const size_t index = series.size();
    series.push_back({level, kSeriesColours[index % std::size(kSeriesColours)], {{*input.by, index}}});
  }
  return series;
}

/// Values that differ by more than this are shown on a logarithmic axis.
bool WantsLogarithm(double low, double high) { return low > 0 && high > 25 * low; }

/// Medians of both coordinates over equally full bins of the first.
Json BinMedians(std::vector<std::pair<double, double>> points) {
  Json json = Json::array();
  std::sort(points.begin(), points.end());
  const size_t bins = std::clamp<size_t>(points.size() / 6, 1, 8);
  for (size_t bin = 0; bin < bins && points.size() >= 3; ++bin) {
    std::vector<double> x, y;
    for (size_t i = bin * points.size() / bins; i < (bin + 1) * points.size() / bins; ++i) {
      x.push_back(points[i].first);
      y.push_back(points[i].second);
    }
    json.push_back({{"x", Significant(MedianOf(x))}, {"y", Significant(MedianOf(y))}, {"n", x.size()}});
  }
  return json;
}

/// The two axes of a heat map, and the axis whose levels have a map each.
struct MapAxes {
  size_t rows = 0, columns = 0;
  std::optional<size_t> each;
};

std::optional<MapAxes> MapAxesOf(const StudyReportInput& input) {
  std::vector<size_t> others;
  for (size_t a = 0; a < input.table->axes.size(); ++a) {
    if (!input.by || *input.by != a) others.push_back(a);
  }
  if (others.size() >= 2) return MapAxes{others[1], others[0], input.by};
  if (others.size() == 1 && input.by) return MapAxes{*input.by, others[0], std::nullopt};
  return std::nullopt;
}

/// Stronger is worse; the scale is that of all maps of this metric.
double Darkness(const Score& metric, double value, double low, double high, bool logarithm) {
  if (!(high > low)) return 0;
  const double part = logarithm ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return metric.better == Better::kHigher ? 1 - part : part;
}

std::string HeatMap(const StudyReportInput& input, const MapAxes& axes, const Score& metric, const std::string& title,
                    const std::vector<std::vector<MedianRow>>& cells, double low, double high) {
  const StudyAxis &rows = input.table->axes[axes.rows], &columns = input.table->axes[axes.columns];
  const bool logarithm = WantsLogarithm(low, high) && metric.better != Better::kHigher;
  std::string html = fmt::format(
      "<section class=\"panel scroll\"><h3>{}</h3>\n<table class=\"map\"><thead><tr><th></th><th "
      "colspan=\"{}\">{}</th></tr>"
      "<tr><th>{}</th>",
      Escape(title), columns.levels.size(), Escape(columns.Title()), Escape(rows.Title()));
  for (const std::string& level : columns.levels) html += "<th>" + Escape(level) + "</th>";
  html += "</tr></thead>\n<tbody>\n";
  for (size_t r = 0; r < rows.levels.size(); ++r) {
    html += "<tr><th>" + Escape(rows.levels[r]) + "</th>";
    for (const MedianRow& cell : cells[r]) {
      if (cell.n == 0) {
        html += fmt::format("<td class=\"empty\">&ndash;<small>0 of {}</small></td>", cell.runs);
        continue;
      }
      html +=
          fmt::format("<td style=\"--t: {:.0f}%\">{}<small>{}</small></td>",
                      8 + 62 * Darkness(metric, cell.median, low, high, logarithm), ThreeDigits(cell.median),
                      cell.n == cell.runs ? fmt::format("n = {}", cell.n) : fmt::format("{} of {}", cell.n, cell.runs));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

}  // namespace

std::vector<KeyEntry> StudyChartKey(const StudyReportInput& input, size_t axis) {
  const std::vector<Series> series = SeriesOf(input, axis);
  std::vector<KeyEntry> key;
  if (series.size() < 2) return key;
  for (const Series& s : series) key.push_back({s.colour, s.name, "", "s" + std::to_string(key.size())});
  return key;
}

std::optional<int> LyingChartHeight_px(const StudyAxis& axis) {
  constexpr size_t kFits = 90;  // characters in all, side by side under a chart of half the page's width
  size_t characters = 0, longest = 0;
  for (const std::string& level : axis.levels) {
    characters += level.size();
    longest = std::max(longest, level.size());
  }
  if (characters <= kFits || !axis.Numbers().empty()) return std::nullopt;
  constexpr size_t kPerLine = 40;  // study.js breaks labels after 44 characters
  constexpr int kLine_px = 14, kGap_px = 10, kFrame_px = 80;
  const int lines = int((longest + kPerLine - 1) / kPerLine);
  return kFrame_px + int(axis.levels.size()) * (lines * kLine_px + kGap_px);
}

Json StudyEffectChart(const StudyReportInput& input, size_t axis, const Score& metric) {
  const StudyAxis& a = input.table->axes[axis];
  const std::vector<double> numbers = a.Numbers();
  Json json{{"kind", "effect"},
            {"x", a.Title()},
            {"y", AxisTitle(metric)},
            {"numeric", !numbers.empty()},
            {"ticks", Json::array()},
            {"labels", a.levels},
            {"series", Json::array()},
            {"ratio", metric.name == "coverage_ratio"},
            {"lying", LyingChartHeight_px(a).has_value()}};
  for (size_t level = 0; level < a.levels.size(); ++level)
    json["ticks"].push_back(numbers.empty() ? double(level) : numbers[level]);
  double low = INFINITY, high = 0;
  for (const Series& series : SeriesOf(input, axis)) {
    Json points = Json::array();
    for (size_t level = 0; level < a.levels.size(); ++level) {
      Levels levels = series.levels;
      levels.emplace_back(axis, level);
      const MedianRow row = MedianAt(input, levels, metric.name);
      points.push_back({{"x", json["ticks"][level]},
                        {"y", Significant(row.median)},
                        {"low", Significant(row.interval.low)},
                        {"high", Significant(row.interval.high)},
                        {"n", row.n},
                        {"runs", row.runs}});
      if (row.n == 0) continue;
      low = std::min(low, row.interval.low);
      high = std::max(high, row.interval.high);
    }
    json["series"].push_back({{"name", series.name}, {"colour", series.colour}, {"points", points}});
  }
  json["log"] = metric.name != "coverage_ratio" && WantsLogarithm(low, high);
  return json;
}

Json StudyBlurChart(const StudyReportInput& input, const Score& metric) {
  Json json{{"kind", "scatter"},
            {"x", "motion blur of the run: median extent, px"},
            {"y", AxisTitle(metric)},
            {"ratio", metric.name == "coverage_ratio"},
            {"series", Json::array()}};
  double low = INFINITY, high = 0;
  for (const Series& series : SeriesOf(input, SIZE_MAX)) {
    std::vector<std::pair<double, double>> points;
    for (const StudyRun* run : RunsAt(*input.table, series.levels)) {
      const double value = run->Value(metric.name);
      if (!std::isfinite(value) || !std::isfinite(run->blur_median_px)) continue;
      points.emplace_back(run->blur_median_px, value);
      low = std::min(low, value);
      high = std::max(high, value);
    }
    Json shown = Json::array();
    const size_t step = points.size() / kMaxPoints + 1;
    for (size_t i = 0; i < points.size(); i += step)
      shown.push_back({{"x", Significant(points[i].first)}, {"y", Significant(points[i].second)}});
    json["series"].push_back(
        {{"name", series.name}, {"colour", series.colour}, {"points", shown}, {"medians", BinMedians(points)}});
  }
  json["log"] = metric.name != "coverage_ratio" && WantsLogarithm(low, high);
  return json;
}

std::string StudyHeatMaps(const StudyReportInput& input, const Score& metric) {
  const std::optional<MapAxes> axes = MapAxesOf(input);
  if (!axes) return {};
  const StudyAxis &rows = input.table->axes[axes->rows], &columns = input.table->axes[axes->columns];
  const size_t maps = axes->each ? input.table->axes[*axes->each].levels.size() : 1;
  if (maps * rows.levels.size() * columns.levels.size() > kMaxCells) return {};
  std::vector<std::vector<std::vector<MedianRow>>> cells(maps);
  double low = INFINITY, high = -INFINITY;
  for (size_t map = 0; map < maps; ++map) {
    cells[map].resize(rows.levels.size());
    for (size_t r = 0; r < rows.levels.size(); ++r) {
      for (size_t c = 0; c < columns.levels.size(); ++c) {
        Levels levels{{axes->rows, r}, {axes->columns, c}};
        if (axes->each) levels.emplace_back(*axes->each, map);
        const MedianRow& cell = cells[map][r].emplace_back(MedianAt(input, levels, metric.name));
        if (cell.n == 0) continue;
        low = std::min(low, cell.median);
        high = std::max(high, cell.median);
      }
    }
  }
  std::string html = "<div class=\"grid halves\">\n";
  for (size_t map = 0; map < maps; ++map) {
    const std::string title = axes->each ? "Medians with " + input.table->axes[*axes->each].levels[map] : "Medians";
    html += HeatMap(input, *axes, metric, title + " (stronger colour is worse)", cells[map], low, high);
  }
  return html + "</div>\n";
}

}  // namespace gaitcam::internal
