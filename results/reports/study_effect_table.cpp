#include "results/reports/study_effect_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "results/reports/html_page.h"

namespace gaitcam::internal {
namespace {

constexpr size_t kOpenRows = 15;  ///< Seen at once.
constexpr size_t kMaxRows = 200;  ///< On the page; all are in effects.csv.

std::string PercentOf(double part) { return fmt::format("{:g} %", 100 * part); }

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
                               : "<span title=\"too few walks for an interval\">&ndash;</span>";
  return fmt::format(
      "<tr><td class=\"number\">{}</td><td><span class=\"pill "
      "{}\">{}</span></td><td>{}</td><td><code>{}</code></td><td "
      "class=\"number plain\">{}</td><td class=\"number plain\">{}</td><td class=\"number plain\">{}</td><td "
      "class=\"number\">{}</td><td class=\"number "
      "plain\">{}</td><td>{}</td><td class=\"number plain\">{}</td><td class=\"number plain\">{}</td></tr>\n",
      rank,
      verdict > 0   ? "good"
      : verdict < 0 ? "bad"
                    : "quiet",
      verdict > 0   ? "better"
      : verdict < 0 ? "worse"
      : sure        ? "differs"
                    : "not sure",
      what, e.metric.name, e.pairs, e.walks, e.pairs > 0 ? ThreeDigits(e.reference) : "&ndash;",
      e.pairs > 0 ? ThreeDigits(e.shift) : "&ndash;", ends, EffectBar(e, verdict), part, PText(e.p_holm));
}

std::string EffectRows(const StudyReportInput& input, size_t begin, size_t end) {
  std::string html = fmt::format(
      "<table "
      "class=\"effects\">\n<thead><tr><th></th><th></th><th>change</th><th>score</th><th>pairs</th><th>walks</th>"
      "<th>reference</th><th>shift</th><th>{} interval</th><th colspan=\"2\">of the "
      "reference</th><th>p</th></tr></thead>\n"
      "<tbody>\n",
      PercentOf(input.statistics.confidence));
  for (size_t i = begin; i < end; ++i) html += EffectRow(input, (*input.effects)[i], i + 1);
  return html + "</tbody></table>\n";
}

}  // namespace

std::string StudyEffectTable(const StudyReportInput& input) {
  const std::string percent = PercentOf(input.statistics.confidence);
  std::string html = fmt::format(
      "<h2>What made a difference</h2>\n<p class=\"note\">Each level against its axis's reference, paired by seed and "
      "by "
      "the levels of all other axes, the surest first. <b>Shift</b>: Hodges-Lehmann estimate of the change, with its "
      "{0} interval (signed-rank test inverted). <b>p</b>: Wilcoxon's signed-rank test, two-sided, corrected for all "
      "{1} "
      "comparisons (Holm). Bars: shift and interval as parts of the reference's median, from &minus;100 % to +100 %. "
      "Scores that are best near 1 or 0 are compared by their distance from it. <b>Walks</b>: all runs of one seed "
      "share "
      "its walk and count once, with the median change of their pairs; shift, interval and p go over walks.</p>\n",
      percent, input.effects->size());
  const std::string too_few = TooFewSeeds(*input.effects, input.statistics.confidence);
  if (!too_few.empty()) html += "<p class=\"note\"><b>" + too_few + "</b></p>\n";
  const size_t first = std::min(kOpenRows, input.effects->size());
  const size_t shown = std::min(kMaxRows, input.effects->size());
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

}  // namespace gaitcam::internal
