#include "scenarios/code/jobs/self_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "algorithms/core/random.h"
#include "results/scoring/score_text.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

constexpr double kMaxFalseAlarmRate = 0.01;
constexpr int kResampledSuites = 10'000;

/// The regression with the largest ratio of shift to margin; null if there is none.
const MetricVerdict* Strongest(const std::vector<EntryVerdict>& verdicts) {
  const MetricVerdict* strongest = nullptr;
  const auto size = [](const MetricVerdict& m) { return m.worse_by / std::max(m.margin, 1e-12); };
  for (const EntryVerdict& entry : verdicts) {
    for (const MetricVerdict& m : entry.metrics) {
      if (m.outcome != Outcome::kRegression) continue;
      if (strongest == nullptr || size(m) > size(*strongest)) strongest = &m;
    }
  }
  return strongest;
}

std::string ByWhat(const std::vector<EntryVerdict>& verdicts) {
  std::vector<std::string> names;
  for (const EntryVerdict& entry : verdicts) {
    for (const MetricVerdict& m : entry.metrics) {
      if (m.outcome == Outcome::kRegression && std::find(names.begin(), names.end(), m.metric.name) == names.end())
        names.push_back(m.metric.name);
    }
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::vector<std::string>> WorseRows(const SelfTestResult& result) {
  std::vector<std::vector<std::string>> rows{
      {"made worse by", "caught", "regressed", "most clearly", "baseline", "now", "worse by", "margin", "p"}};
  for (const SelfTestResult::Worse& worse : result.worse) {
    std::vector<std::string> row{worse.name, worse.caught ? "yes" : "NO", ByWhat(worse.verdicts)};
    if (const MetricVerdict* m = Strongest(worse.verdicts)) {
      for (const double value : {m->before.median, m->now.median, m->worse_by, m->margin})
        row.push_back(ScoreText(value));
      row.insert(row.begin() + 3, m->metric.name);
      row.push_back(std::isfinite(m->p_worse) ? fmt::format("{:.4f}", m->p_worse) : "-");
    }
    row.resize(rows.front().size(), "-");
    rows.push_back(row);
  }
  return rows;
}

/// Which system's gate caught which worse system, and by what.
std::vector<std::vector<std::string>> CaughtRows(const SelfTestResult& result) {
  std::vector<std::vector<std::string>> rows{{"made worse by"}};
  for (const EntryVerdict& entry : result.as_it_is) rows[0].push_back(entry.scenario + ", " + entry.system);
  for (const SelfTestResult::Worse& worse : result.worse) {
    std::vector<std::string> row{worse.name};
    for (const EntryVerdict& column : result.as_it_is) {
      const auto here = std::find_if(worse.verdicts.begin(), worse.verdicts.end(), [&](const EntryVerdict& entry) {
        return entry.scenario == column.scenario && entry.system == column.system;
      });
      if (here == worse.verdicts.end()) {
        row.push_back("-");
      } else {
        row.push_back(HasRegressed(*here) ? ByWhat({*here}) : "not caught");
      }
    }
    rows.push_back(row);
  }
  return rows;
}

/// Per scenario, system and metric: the distribution of shifts due to the random stream alone.
std::vector<std::vector<std::string>> RerunRows(const SelfTestResult& result) {
  std::vector<std::vector<std::string>> rows{
      {"scenario", "system", "metric", "margin", "worse by: median", "5 %", "95 %", "largest", "alarms"}};
  if (result.reruns.empty()) return rows;
  for (size_t e = 0; e < result.reruns.front().size(); ++e) {
    for (size_t k = 0; k < result.reruns.front()[e].metrics.size(); ++k) {
      std::vector<double> shifts;
      int alarms = 0;
      for (const std::vector<EntryVerdict>& rerun : result.reruns) {
        const MetricVerdict& m = rerun[e].metrics[k];
        if (std::isfinite(m.worse_by)) shifts.push_back(m.worse_by);
        alarms += m.outcome == Outcome::kRegression;
      }
      const EntryVerdict& entry = result.reruns.front()[e];
      rows.push_back({entry.scenario, entry.system, entry.metrics[k].metric.name, ScoreText(entry.metrics[k].margin),
                      ScoreText(MedianOf(shifts)), ScoreText(QuantileOf(shifts, 0.05)),
                      ScoreText(QuantileOf(shifts, 0.95)), ScoreText(QuantileOf(shifts, 1)),
                      fmt::format("{}", alarms)});
    }
  }
  return rows;
}

std::string RatesText(const SelfTestResult& result) {
  std::string text = fmt::format("caught {} of {} worse systems", result.Caught(), result.worse.size());
  if (!result.reruns.empty()) {
    text += fmt::format(
        "; {} false alarm{} in {} re-runs ({:.1f} %, at most {:g} % permitted), {} of them by a single "
        "seed",
        result.FalseAlarms(), result.FalseAlarms() == 1 ? "" : "s", result.reruns.size(),
        100.0 * result.FalseAlarms() / double(result.reruns.size()), 100 * kMaxFalseAlarmRate, result.AlarmsBySeed());
  }
  if (result.resampled > 0) {
    text += fmt::format("; {} in {} suites put together from their runs ({:.2f} %)", result.resampled_alarms,
                        result.resampled, 100.0 * result.resampled_alarms / result.resampled);
  }
  if (HasRegressed(result.as_it_is)) text += "; the suite as it is does NOT pass";
  return text;
}

/// A suite whose every run is one of those that the re-runs of the same system on the same walk made.
std::vector<MeasuredEntry> DrawSuite(std::span<const MeasuredVariant> reruns, RandomStream& random) {
  std::vector<MeasuredEntry> drawn = reruns.front().entries;
  for (size_t e = 0; e < drawn.size(); ++e) {
    for (size_t k = 0; k < drawn[e].runs.size(); ++k)
      drawn[e].runs[k] = reruns[size_t(random.Index(int(reruns.size())))].entries[e].runs[k];
  }
  return drawn;
}

void JudgeResampled(const Suite& suite, const Baseline& baseline, std::span<const MeasuredVariant> reruns,
                    SelfTestResult& result) {
  if (reruns.size() < 2) return;
  RandomStream random(1, "self_test.resampled");
  result.resampled = kResampledSuites;
  for (int i = 0; i < result.resampled; ++i)
    result.resampled_alarms += HasRegressed(JudgeAgainst(suite, baseline, DrawSuite(reruns, random)));
}

std::string CommandText(const Suite& suite, const SelfTestResult& result) {
  return fmt::format("gaitcam check {} --self-test --reruns {}", suite.options.name, result.reruns.size());
}

}  // namespace

int SelfTestResult::Caught() const {
  return int(std::count_if(worse.begin(), worse.end(), [](const Worse& w) { return w.caught; }));
}

int SelfTestResult::FalseAlarms() const {
  return int(std::count_if(reruns.begin(), reruns.end(),
                           [](const std::vector<EntryVerdict>& rerun) { return HasRegressed(rerun); }));
}

int SelfTestResult::AlarmsBySeed() const {
  const auto by_seed = [](const std::vector<EntryVerdict>& rerun) {
    return std::any_of(rerun.begin(), rerun.end(), [](const EntryVerdict& entry) {
      return std::any_of(entry.metrics.begin(), entry.metrics.end(),
                         [](const MetricVerdict& m) { return m.far_seeds > 0; });
    });
  };
  return int(std::count_if(reruns.begin(), reruns.end(), by_seed));
}

bool SelfTestResult::Passed() const {
  return !interrupted && Caught() == int(worse.size()) && ExitCodeOf(as_it_is) == 0 &&
         FalseAlarms() <= kMaxFalseAlarmRate * double(reruns.size());
}

SelfTestResult RunSelfTest(const Suite& suite, const Baseline& baseline, int reruns, const ExecutorOptions& options) {
  std::vector<SuiteVariant> variants{{"", suite.entries}};
  for (const WorseSystem& worse : suite.options.self_test) variants.push_back({worse.name, suite.EntriesOf(worse)});
  for (int i = 1; i <= reruns; ++i) variants.push_back(RerunOf(suite, uint64_t(i)));
  const SuiteMeasurement measured = MeasureSuite(suite, variants, options);
  SelfTestResult result;
  result.renderer = measured.renderer;
  result.runs = measured.runs;
  result.reused = measured.reused;
  result.wall_s = measured.wall_s;
  result.interrupted = measured.interrupted;
  const size_t worse = suite.options.self_test.size();
  for (size_t i = 0; i < measured.variants.size(); ++i) {
    const MeasuredVariant& variant = measured.variants[i];
    std::vector<EntryVerdict> verdicts = JudgeAgainst(suite, baseline, variant.entries);
    if (i == 0) {
      result.as_it_is = std::move(verdicts);
    } else if (i <= worse) {
      const bool caught = HasRegressed(verdicts);
      result.worse.push_back({variant.name, std::move(verdicts), caught});
    } else {
      result.reruns.push_back(std::move(verdicts));
    }
  }
  if (!measured.interrupted) JudgeResampled(suite, baseline, std::span(measured.variants).subspan(worse + 1), result);
  return result;
}

std::string SelfTestText(const Suite& suite, const SelfTestResult& result) {
  std::string text = AlignedTable(WorseRows(result)) + "\n" + AlignedTable(CaughtRows(result));
  if (!result.reruns.empty()) text += "\n" + AlignedTable(RerunRows(result));
  return text + fmt::format("\n{}: {}; {} runs ({} reused) in {:.0f} s\n", suite.options.name, RatesText(result),
                            result.runs, result.reused, result.wall_s);
}

std::string SelfTestMarkdown(const Suite& suite, const SelfTestResult& result) {
  std::string text = fmt::format("## The gate `{}`: {}\n\n", suite.options.name, RatesText(result));
  text += fmt::format("Made by `{}`; frames by {}.\n\n", CommandText(suite, result), result.renderer);
  text += fmt::format(
      "{} pair{} of scenario and system, {} seeds each; the rule is {} at a one-sided level of {:g}, beyond the "
      "margin. "
      "Figures "
      "are medians over the seeds; `worse by` is the paired shift, positive is worse.\n\n",
      suite.entries.size(), suite.entries.size() == 1 ? "" : "s", suite.options.seeds.size(),
      suite.options.gate.test == PairedTest::kSignedRank ? "Wilcoxon's signed-rank test"
                                                         : "a bootstrap interval of the median",
      suite.options.gate.alpha);
  text += MarkdownTable(WorseRows(result));
  text += "\nBy system: the metrics that regressed. What one system's gate lets pass, another's may catch.\n\n";
  text += MarkdownTable(CaughtRows(result));
  if (!result.reruns.empty()) {
    text += fmt::format(
        "\nRe-runs in which only the random stream of the SLAM system differs, {} of them, each judged against the "
        "same baseline:\n\n",
        result.reruns.size());
    text += MarkdownTable(RerunRows(result));
  }
  return text;
}

std::string SelfTestJson(const SelfTestResult& result) {
  nlohmann::ordered_json json{{"schema", "gaitcam.self_test.1"},
                              {"passed", result.Passed()},
                              {"caught", result.Caught()},
                              {"worse", nlohmann::ordered_json::array()},
                              {"false_alarms", result.FalseAlarms()},
                              {"reruns", result.reruns.size()},
                              {"resampled", result.resampled},
                              {"resampled_alarms", result.resampled_alarms}};
  for (const SelfTestResult::Worse& worse : result.worse)
    json["worse"].push_back({{"name", worse.name}, {"caught", worse.caught}, {"by", ByWhat(worse.verdicts)}});
  return json.dump(2) + "\n";
}

}  // namespace gaitcam
