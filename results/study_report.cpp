#include "results/study_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "results/html_page.h"
#include "results/study_page.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;
using internal::Banner;
using internal::Card;
using internal::Escape;
using internal::KeyEntry;
using internal::Panel;
using internal::ThreeDigits;

constexpr const char* kColours[] = {"sim3", "se3", "green", "purple", "truth", "muted"};
constexpr size_t kMostPoints = 1500;  // of one series of a scatter plot
constexpr size_t kFirstEffects = 15;  // rows of the table on the page that are seen at once
constexpr size_t kMostEffects = 200;  // ... and that are there
constexpr size_t kMostCellsOfMap = 400;

Json Rounded(double value) { return std::isfinite(value) ? Json(std::stod(fmt::format("{:.5g}", value))) : Json(); }

std::string Percent(double part) { return fmt::format("{:g} %", 100 * part); }

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

/// Medians of a page; each is asked for by its levels.
class Medians {
 public:
  explicit Medians(const StudyReportInput& input) : input_(input) {}
  MedianRow At(const Levels& levels, const std::string& score) const {
    std::string label = "page";
    for (const auto& [axis, level] : levels) label += fmt::format("/{}={}", axis, level);
    return SummarizeRuns(RunsAt(*input_.table, levels), score, input_.statistics, label);
  }

 private:
  const StudyReportInput& input_;
};

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
    series.push_back({level, kColours[index % std::size(kColours)], {{*input.by, index}}});
  }
  return series;
}

std::vector<KeyEntry> KeyOf(const std::vector<Series>& series) {
  std::vector<KeyEntry> key;
  if (series.size() < 2) return key;
  for (const Series& s : series) key.push_back({s.colour, s.name, "", "s" + std::to_string(key.size())});
  return key;
}

/// Values that differ by more than this are shown on a logarithmic axis.
bool WantsLogarithm(double low, double high) { return low > 0 && high > 25 * low; }

Json EffectChart(const StudyReportInput& input, const Medians& medians, size_t axis, const Score& metric) {
  const StudyAxis& a = input.table->axes[axis];
  const std::vector<double> numbers = a.Numbers();
  Json json{{"kind", "effect"},        {"x", a.Title()},
            {"y", AxisTitle(metric)},  {"numeric", !numbers.empty()},
            {"ticks", Json::array()},  {"labels", a.levels},
            {"series", Json::array()}, {"ratio", metric.name == "coverage_ratio"}};
  for (size_t level = 0; level < a.levels.size(); ++level)
    json["ticks"].push_back(numbers.empty() ? double(level) : numbers[level]);
  double low = INFINITY, high = 0;
  for (const Series& series : SeriesOf(input, axis)) {
    Json points = Json::array();
    for (size_t level = 0; level < a.levels.size(); ++level) {
      Levels levels = series.levels;
      levels.emplace_back(axis, level);
      const MedianRow row = medians.At(levels, metric.name);
      points.push_back({{"x", json["ticks"][level]},
                        {"y", Rounded(row.median)},
                        {"low", Rounded(row.interval.low)},
                        {"high", Rounded(row.interval.high)},
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
    json.push_back({{"x", Rounded(MedianOf(x))}, {"y", Rounded(MedianOf(y))}, {"n", x.size()}});
  }
  return json;
}

Json ScatterChart(const StudyReportInput& input, const Score& metric) {
  Json json{{"kind", "scatter"},
            {"x", "motion blur of the run: median extent, px"},
            {"y", AxisTitle(metric)},
            {"ratio", metric.name == "coverage_ratio"},
            {"series", Json::array()}};
  double low = INFINITY, high = 0;
  for (const Series& series : SeriesOf(input, input.table->axes.size())) {
    std::vector<std::pair<double, double>> points;
    for (const StudyRun* run : RunsAt(*input.table, series.levels)) {
      const double value = run->Value(metric.name);
      if (!std::isfinite(value) || !std::isfinite(run->blur_median_px)) continue;
      points.emplace_back(run->blur_median_px, value);
      low = std::min(low, value);
      high = std::max(high, value);
    }
    Json shown = Json::array();
    const size_t step = points.size() / kMostPoints + 1;
    for (size_t i = 0; i < points.size(); i += step)
      shown.push_back({{"x", Rounded(points[i].first)}, {"y", Rounded(points[i].second)}});
    json["series"].push_back(
        {{"name", series.name}, {"colour", series.colour}, {"points", shown}, {"medians", BinMedians(points)}});
  }
  json["log"] = metric.name != "coverage_ratio" && WantsLogarithm(low, high);
  return json;
}

// ---- The page, from top to bottom

size_t Scored(const StudyTable& table, const Score& metric) {
  return size_t(std::count_if(table.runs.begin(), table.runs.end(),
                              [&](const StudyRun& run) { return std::isfinite(run.Value(metric.name)); }));
}

std::string Header(const StudyTable& table) {
  return fmt::format("<header>\n<span class=\"brand\">gaitcam study</span>\n<h1>{}</h1>\n<p>{}</p>\n</header>\n",
                     Escape(table.name), Escape(table.description));
}

std::string Banners(const StudyTable& table) {
  std::map<std::string, size_t> failed;
  size_t fell = 0, unscored = 0;
  for (const StudyRun& run : table.runs) {
    if (run.status == "failed") ++failed[run.failure];
    fell += run.status == "fell";
    unscored += run.status != "failed" && run.scores.size() < 2;
  }
  std::string html;
  for (const auto& [reason, count] : failed)
    html += Banner("bad", fmt::format("{} of {} runs failed.", count, table.runs.size()), reason);
  if (unscored > 0) {
    html += Banner("warn", fmt::format("{} of {} runs covered too little to be scored.", unscored, table.runs.size()),
                   "They are missing from every figure of accuracy, which flatters the conditions that they belong "
                   "to: read coverage first.");
  }
  if (fell > 0) {
    html += Banner("warn", fmt::format("The robot fell in {} of {} runs.", fell, table.runs.size()),
                   "What was filmed until then is scored.");
  }
  return html;
}

std::string Cards(const StudyReportInput& input) {
  const StudyTable& table = *input.table;
  size_t sure = 0;
  for (const StudyEffect& e : *input.effects) sure += e.p_holm < 1 - input.statistics.confidence;
  std::vector<double> blur;
  for (const StudyRun& run : table.runs) {
    if (std::isfinite(run.blur_median_px)) blur.push_back(run.blur_median_px);
  }
  std::string html = "<dl class=\"cards\">\n";
  html += Card("Runs", double(table.runs.size()), "",
               fmt::format("{} conditions, each with the same {} seeds", table.conditions(), table.seeds));
  const Score& last = table.metrics.back();
  html += Card("Scored", double(Scored(table, last)), "runs", fmt::format("have {}", last.name));
  html +=
      Card("Motion blur", QuantileOf(blur, 1.0), "px",
           fmt::format("median extent of the most blurred run; {} px of the least", ThreeDigits(QuantileOf(blur, 0))));
  html += Card("Sure effects", double(sure), "",
               fmt::format("of {} comparisons, after correction for all of them", input.effects->size()));
  return html + "</dl>\n";
}

/// Shift and interval as parts of the reference, drawn between -100 % and +100 %.
std::string EffectBar(const StudyEffect& e, int verdict) {
  constexpr double kHalf = 50;
  const auto at = [&](double value) { return kHalf * (1 + std::clamp(value / std::abs(e.reference), -1.0, 1.0)); };
  std::string svg = fmt::format(
      "<svg width=\"{0:.0f}\" height=\"16\" viewBox=\"0 0 {0:.0f} 16\" aria-hidden=\"true\"><line x1=\"{1:.0f}\" "
      "x2=\"{1:.0f}\" y1=\"0\" y2=\"16\" class=\"zero\"/>",
      2 * kHalf, kHalf);
  if (e.pairs > 0 && e.reference != 0 && std::isfinite(e.shift)) {
    const char* kind = verdict > 0 ? "good" : verdict < 0 ? "bad" : "none";
    if (std::isfinite(e.ends.low))
      svg += fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"8\" y2=\"8\" class=\"bar {}\"/>", at(e.ends.low),
                         at(e.ends.high), kind);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"8\" r=\"3.5\" class=\"{}\"/>", at(e.shift), kind);
  }
  return svg + "</svg>";
}

std::string PText(double p) {
  if (p < 1e-4) return "&lt; 0.0001";
  return fmt::format("{:.2g}", p);
}

std::string EffectRow(const StudyReportInput& input, const StudyEffect& e, size_t rank) {
  const StudyAxis& axis = input.table->axes[e.axis];
  const int verdict = e.Verdict(input.statistics.confidence);
  const bool sure = e.p_holm < 1 - input.statistics.confidence;
  std::string what = fmt::format("{}: <b>{}</b> vs {}", Escape(axis.Title()), Escape(axis.levels[e.level]),
                                 Escape(axis.levels[axis.reference]));
  if (e.within)
    what += fmt::format(" <span class=\"within\">with {}</span>",
                        Escape(input.table->axes[e.within->first].levels[e.within->second]));
  const std::string part =
      e.pairs > 0 && e.reference != 0 ? fmt::format("{:+.0f} %", 100 * e.shift / std::abs(e.reference)) : "";
  const std::string ends = std::isfinite(e.ends.low)
                               ? fmt::format("[{}, {}]", ThreeDigits(e.ends.low), ThreeDigits(e.ends.high))
                               : "<span title=\"too few pairs for an interval\">&ndash;</span>";
  return fmt::format(
      "<tr><td class=\"number\">{}</td><td><span class=\"pill "
      "{}\">{}</span></td><td>{}</td><td><code>{}</code></td><td "
      "class=\"number plain\">{}</td><td class=\"number plain\">{}</td><td class=\"number\">{}</td><td class=\"number "
      "plain\">{}</td><td>{}</td><td class=\"number plain\">{}</td><td class=\"number plain\">{}</td></tr>\n",
      rank,
      verdict > 0   ? "good"
      : verdict < 0 ? "bad"
                    : "quiet",
      verdict > 0   ? "better"
      : verdict < 0 ? "worse"
      : sure        ? "differs"
                    : "not sure",
      what, e.metric.name, e.pairs, e.pairs > 0 ? ThreeDigits(e.reference) : "&ndash;",
      e.pairs > 0 ? ThreeDigits(e.shift) : "&ndash;", ends, EffectBar(e, verdict), part, PText(e.p_holm));
}

std::string EffectRows(const StudyReportInput& input, size_t begin, size_t end) {
  std::string html = fmt::format(
      "<table class=\"effects\">\n<thead><tr><th></th><th></th><th>change</th><th>score</th><th>pairs</th>"
      "<th>reference</th><th>shift</th><th>{} interval</th><th colspan=\"2\">of the "
      "reference</th><th>p</th></tr></thead>\n"
      "<tbody>\n",
      Percent(input.statistics.confidence));
  for (size_t i = begin; i < end; ++i) html += EffectRow(input, (*input.effects)[i], i + 1);
  return html + "</tbody></table>\n";
}

std::string EffectTable(const StudyReportInput& input) {
  const std::string percent = Percent(input.statistics.confidence);
  std::string html = fmt::format(
      "<h2>What made a difference</h2>\n<p class=\"note\">Each level against its axis's reference, paired by seed and "
      "by "
      "the levels of all other axes, the surest first. <b>Shift</b>: Hodges-Lehmann estimate of the change, with its "
      "{0} interval (signed-rank test inverted). <b>p</b>: Wilcoxon's signed-rank test, two-sided, corrected for all "
      "{1} "
      "comparisons (Holm). Bars: shift and interval as parts of the reference's median, from &minus;100 % to +100 %. "
      "Scores that are best near 1 or 0 are compared by their distance from it. Pairs that share a seed share its "
      "walk, so p is a little too small.</p>\n",
      percent, input.effects->size());
  const size_t first = std::min(kFirstEffects, input.effects->size());
  const size_t shown = std::min(kMostEffects, input.effects->size());
  html += "<div class=\"panel scroll\">" + EffectRows(input, 0, first) + "</div>\n";
  if (shown > first) {
    html += fmt::format(
        "<details class=\"panel scroll more\"><summary>{} more comparisons, none surer</summary>{}</details>\n",
        shown - first, EffectRows(input, first, shown));
  }
  if (shown < input.effects->size())
    html += fmt::format("<p class=\"note\">{} more are in effects.csv.</p>\n", input.effects->size() - shown);
  return html;
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

std::string HeatMaps(const StudyReportInput& input, const Medians& medians, const Score& metric) {
  const std::optional<MapAxes> axes = MapAxesOf(input);
  if (!axes) return {};
  const StudyAxis &rows = input.table->axes[axes->rows], &columns = input.table->axes[axes->columns];
  const size_t maps = axes->each ? input.table->axes[*axes->each].levels.size() : 1;
  if (maps * rows.levels.size() * columns.levels.size() > kMostCellsOfMap) return {};
  std::vector<std::vector<std::vector<MedianRow>>> cells(maps);
  double low = INFINITY, high = -INFINITY;
  for (size_t map = 0; map < maps; ++map) {
    cells[map].resize(rows.levels.size());
    for (size_t r = 0; r < rows.levels.size(); ++r) {
      for (size_t c = 0; c < columns.levels.size(); ++c) {
        Levels levels{{axes->rows, r}, {axes->columns, c}};
        if (axes->each) levels.emplace_back(*axes->each, map);
        const MedianRow& cell = cells[map][r].emplace_back(medians.At(levels, metric.name));
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

/// All that concerns one score; its charts' data go into `charts`.
std::string MetricSection(const StudyReportInput& input, const Medians& medians, size_t index, Json& charts) {
  const StudyTable& table = *input.table;
  const Score& metric = table.metrics[index];
  std::string html =
      fmt::format("<h2><code>{}</code></h2>\n<p class=\"note\">{}{}. {} of {} runs have it.</p>\n", metric.name,
                  Escape(metric.meaning), metric.unit.empty() ? "" : ", in " + Escape(metric.unit),
                  Scored(table, metric), table.runs.size());
  html += "<div class=\"grid halves\">\n";
  for (size_t axis = 0; axis < table.axes.size(); ++axis) {
    if (input.by && *input.by == axis && table.axes.size() > 1) continue;  // these are the series of the others
    const std::string id = fmt::format("m{}a{}", index, axis);
    charts[id] = EffectChart(input, medians, axis, metric);
    html += Panel(id, "By " + table.axes[axis].Title(), KeyOf(SeriesOf(input, axis)), 290);
  }
  const std::string id = fmt::format("m{}blur", index);
  charts[id] = ScatterChart(input, metric);
  html +=
      Panel(id, "Over measured motion blur: runs, and medians of bins", KeyOf(SeriesOf(input, table.axes.size())), 290);
  return html + "</div>\n" + HeatMaps(input, medians, metric);
}

std::string Provenance(const StudyReportInput& input) {
  std::string html = "<h2>How it was made</h2>\n" + internal::Facts(input.facts);
  if (!input.study_file.empty())
    html += fmt::format("<details class=\"panel\"><summary>Study file</summary><pre>{}</pre></details>\n",
                        Escape(input.study_file));
  return html;
}

}  // namespace

std::string StudyReportHtml(const StudyReportInput& input) {
  const StudyTable& table = *input.table;
  const Medians medians(input);
  Json charts = Json::object();
  internal::HtmlPage page;
  page.title = table.name;
  page.body = Header(table) + Banners(table) + Cards(input) + EffectTable(input);
  page.body += fmt::format(
      "<p class=\"note after\">In the charts below a point is the median over all runs at that level, whatever the "
      "other "
      "axes "
      "and the seed; bars are its {} bootstrap interval ({} resamples). Point at one for its numbers.</p>\n",
      Percent(input.statistics.confidence), input.statistics.resamples);
  for (size_t m = 0; m < table.metrics.size(); ++m) page.body += MetricSection(input, medians, m, charts);
  page.body += Provenance(input);
  page.data = Json{{"charts", charts}}.dump();
  page.style = internal::StudyStyle();
  page.script = internal::StudyScript();
  return internal::PageHtml(page, {});
}

}  // namespace gaitcam
