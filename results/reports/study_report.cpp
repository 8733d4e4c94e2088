#include "results/reports/study_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/reports/study_charts.h"
#include "results/reports/study_effect_table.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;
using internal::Banner;
using internal::Card;
using internal::Escape;
using internal::Panel;
using internal::ThreeDigits;

size_t Scored(const StudyTable& table, const Score& metric) {
  return size_t(std::count_if(table.runs.begin(), table.runs.end(),
                              [&](const StudyRun& run) { return std::isfinite(run.Value(metric.name)); }));
}

bool IsUnscored(const StudyRun& run) { return run.scores.size() < 2; }  // it may have its coverage

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
    unscored += run.status != "failed" && IsUnscored(run);
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
  const auto unscored = size_t(std::count_if(table.runs.begin(), table.runs.end(), IsUnscored));
  html += Card("Scored", double(table.runs.size() - unscored), "runs",
               unscored == 0 ? "none failed or covered too little" : "the others failed, or covered too little");
  html +=
      Card("Motion blur", QuantileOf(blur, 1.0), "px",
           fmt::format("median extent of the most blurred run; {} px of the least", ThreeDigits(QuantileOf(blur, 0))));
  html += Card("Sure effects", double(sure), "",
               fmt::format("of {} comparisons, after correction for all of them", input.effects->size()));
  return html + "</dl>\n";
}

/// All that concerns one score; its charts' data go into `charts`.
std::string MetricSection(const StudyReportInput& input, size_t index, Json& charts) {
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
    charts[id] = internal::StudyEffectChart(input, axis, metric);
    constexpr int kHeight_px = 290;
    const std::optional<int> lying_px = internal::LyingChartHeight_px(table.axes[axis]);
    const std::string panel = Panel(id, "By " + table.axes[axis].Title(), internal::StudyChartKey(input, axis),
                                    lying_px.value_or(kHeight_px));
    html += lying_px ? "<div class=\"wide\">" + panel + "</div>\n" : panel;
  }
  const std::string id = fmt::format("m{}blur", index);
  charts[id] = internal::StudyBlurChart(input, metric);
  html +=
      Panel(id, "Over measured motion blur: runs, and medians of bins", internal::StudyChartKey(input, SIZE_MAX), 290);
  return html + "</div>\n" + internal::StudyHeatMaps(input, metric);
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
  Json charts = Json::object();
  internal::HtmlPage page;
  page.title = table.name;
  page.body = Header(table) + Banners(table) + Cards(input) + internal::StudyEffectTable(input);
  page.body += fmt::format(
      "<p class=\"note after\">In the charts below a point is the median over all runs at that level, whatever the "
      "other "
      "axes "
      "and the seed; bars are its {} bootstrap interval ({} resamples, which draw whole seeds: "
      "runs of one seed share its walk). Point at one for its numbers.</p>\n",
      fmt::format("{:g} %", 100 * input.statistics.confidence), input.statistics.resamples);
  for (size_t m = 0; m < table.metrics.size(); ++m) page.body += MetricSection(input, m, charts);
  page.body += Provenance(input);
  page.data = Json{{"charts", charts}}.dump();
  page.style = internal::PageFile("study.css");
  page.script = internal::PageFile("study.js");
  return internal::PageHtml(page, {});
}

}  // namespace gaitcam
