#include "results/scoring/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

constexpr int kResamples = 4000;
constexpr const char* kCoverage = "coverage_ratio";

const MeasuredRun* Find(const MeasuredEntry& entry, uint64_t seed) {
  for (const MeasuredRun& run : entry.runs) {
    if (run.seed == seed) return &run;
  }
  return nullptr;
}

/// What a run covered; one that left nothing behind covered nothing.
double CoverageOf(const MeasuredRun& run) {
  const double value = run.Value(kCoverage);
  return std::isfinite(value) ? value : 0;
}

/// Why a run is lost; empty if it is not.
std::string LossReason(const MeasuredRun& before, const MeasuredRun& now, const GateRules& rules) {
  if (now.state > before.state) return now.reason;
  if (before.state != RunState::kScored || now.state != RunState::kScored) return "";
  if (CoverageOf(now) >= rules.lost_below * CoverageOf(before)) return "";
  return fmt::format("covers {:.1f} % of the frames, no longer {:.1f} %", 100 * CoverageOf(now),
                     100 * CoverageOf(before));
}

Spread SpreadOf(const std::vector<double>& values) {
  return {MedianOf(values), QuantileOf(values, 0), QuantileOf(values, 1)};
}

/// The values of one metric on both sides, in the order of the baseline's seeds.
struct Pairs {
  std::vector<double> before, now;          ///< Of seeds with both.
  std::vector<const MeasuredRun*> runs;     ///< The baseline's of these seeds.
  std::vector<double> all_before, all_now;  ///< Of all that have any.
  int left_out = 0;
  std::vector<uint64_t> vanished;  ///< Seeds of runs that are scored now as before, but without this value.
};

Pairs PairCoverage(const MeasuredEntry& before, const MeasuredEntry& now) {
  Pairs pairs;
  for (const MeasuredRun& run : before.runs) {
    const MeasuredRun* other = Find(now, run.seed);
    pairs.left_out += other == nullptr;
    if (other == nullptr) continue;
    pairs.runs.push_back(&run);
    pairs.before.push_back(CoverageOf(run));
    pairs.now.push_back(CoverageOf(*other));
  }
  const auto is_known = [](const MeasuredRun& run) { return std::isfinite(run.Value(kCoverage)); };
  const bool known = std::any_of(before.runs.begin(), before.runs.end(), is_known) ||
                     std::any_of(now.runs.begin(), now.runs.end(), is_known);
  if (!known) return pairs;  // a system that gives no poses: there is no coverage to show
  pairs.all_before = pairs.before;
  pairs.all_now = pairs.now;
  return pairs;
}

/// Lost runs are no pairs: their errors are of fewer frames.
Pairs PairMetric(const MeasuredEntry& before, const MeasuredEntry& now, const std::string& metric,
                 const std::vector<LostRun>& lost) {
  Pairs pairs;
  const auto value_of = [&](const MeasuredRun* run) {
    return run != nullptr && run->state == RunState::kScored ? run->Value(metric) : kNaN;
  };
  for (const MeasuredRun& run : before.runs) {
    const MeasuredRun* other = Find(now, run.seed);
    const bool is_lost = std::any_of(lost.begin(), lost.end(), [&](const LostRun& l) { return l.seed == run.seed; });
    const double a = value_of(&run), b = value_of(other);
    if (std::isfinite(a)) pairs.all_before.push_back(a);
    if (std::isfinite(b)) pairs.all_now.push_back(b);
    if (std::isfinite(a) && std::isfinite(b) && !is_lost) {
      pairs.runs.push_back(&run);
      pairs.before.push_back(a);
      pairs.now.push_back(b);
      continue;
    }
    ++pairs.left_out;
    if (std::isfinite(a) && other != nullptr && !is_lost) pairs.vanished.push_back(run.seed);
  }
  return pairs;
}

/// Fills in shift and significance. @returns whether it is significantly worse and better.
std::pair<bool, bool> TestShift(const std::vector<double>& worse, const GateRules& rules, MetricVerdict& verdict) {
  if (rules.test == PairedTest::kBootstrap) {
    RandomStream random(1, "gate_bootstrap." + verdict.metric.name);
    const ConfidenceInterval interval = BootstrapMedian(worse, 1 - 2 * rules.alpha, kResamples, random);
    verdict.worse_by = MedianOf(worse);
    verdict.interval = {verdict.worse_by, interval.low, interval.high};
    verdict.p_worse = verdict.p_better = kNaN;
    return {interval.low > 0, interval.high < 0};
  }
  const SignedRankTest test = TestSignedRanks(worse);
  verdict.worse_by = HodgesLehmann(worse);
  verdict.p_worse = test.p_greater;
  verdict.p_better = test.p_less;
  return {test.p_greater <= rules.alpha, test.p_less <= rules.alpha};
}

/// What a seed's losses were in the baseline and its re-runs; smallest and largest.
std::pair<double, double> HistoryOf(const MeasuredRun& run, const GatedMetric& metric) {
  std::vector<double> losses;
  const auto add = [&](double value) {
    if (std::isfinite(value)) losses.push_back(LossOf(value, metric));
  };
  add(run.Value(metric.name));
  if (const auto history = run.history.find(metric.name); history != run.history.end()) {
    for (const double value : history->second) add(value);
  }
  if (losses.empty()) return {kNaN, kNaN};
  const auto [least, most] = std::minmax_element(losses.begin(), losses.end());
  return {*least, *most};
}

/// Seeds whose own re-runs spread by more than would be an alarm, in any metric: nothing that one of them does says
/// that the system is another.
std::vector<uint64_t> RestlessSeeds(const MeasuredEntry& before, const std::vector<MetricVerdict>& verdicts,
                                    const GateRules& rules) {
  std::vector<uint64_t> restless;
  if (rules.seed_margins <= 0) return restless;
  for (const MeasuredRun& run : before.runs) {
    const bool spreads = std::any_of(verdicts.begin(), verdicts.end(), [&](const MetricVerdict& verdict) {
      const auto [least, most] = HistoryOf(run, verdict.metric);
      return verdict.metric.name != kCoverage && verdict.margin > 0 &&
             most - least > rules.seed_margins * verdict.margin;
    });
    if (spreads) restless.push_back(run.seed);
  }
  return restless;
}

/// Turns the verdict into a regression if a single seed is far outside its own history. What a seed lost in coverage,
/// lost_below judges.
void JudgeSeeds(const Pairs& pairs, const std::vector<uint64_t>& restless, const GateRules& rules,
                MetricVerdict& verdict) {
  if (rules.seed_margins <= 0 || verdict.margin <= 0) return;
  for (size_t i = 0; i < pairs.now.size(); ++i) {
    const uint64_t seed = pairs.runs[i]->seed;
    const auto [least, most] = HistoryOf(*pairs.runs[i], verdict.metric);
    const double now = LossOf(pairs.now[i], verdict.metric);
    const double beyond = std::max(now - most, verdict.metric.change ? least - now : 0);
    if (!(beyond > rules.seed_margins * verdict.margin)) continue;
    if (std::find(restless.begin(), restless.end(), seed) != restless.end()) continue;
    if (verdict.far_seeds++ > 0 || verdict.outcome == Outcome::kRegression) continue;
    verdict.outcome = Outcome::kRegression;
    verdict.reason = fmt::format("seed {}: {:.4g}, before {:.4g}; worse than all its history by more than {:g} margins",
                                 seed, pairs.now[i], pairs.before[i], rules.seed_margins);
  }
}

MetricVerdict JudgePairs(const GatedMetric& metric, const Pairs& pairs, const GateRules& rules) {
  MetricVerdict verdict;
  verdict.metric = metric;
  verdict.before = SpreadOf(pairs.all_before);
  verdict.now = SpreadOf(pairs.all_now);
  verdict.pairs = int(pairs.before.size());
  verdict.left_out = pairs.left_out;
  std::vector<double> losses, worse;
  for (size_t i = 0; i < pairs.before.size(); ++i) {
    losses.push_back(LossOf(pairs.before[i], metric));
    worse.push_back(LossOf(pairs.now[i], metric) - losses.back());
  }
  if (metric.change && HodgesLehmann(worse) < 0) {
    for (double& by : worse) by = -by;
  }
  const double relative = losses.empty() ? 0 : metric.margin_pct / 100 * std::abs(MedianOf(losses));
  verdict.margin = std::max(metric.margin, relative);
  const auto [is_worse, is_better] = TestShift(worse, rules, verdict);
  const int needed = rules.min_pairs > 0 ? rules.min_pairs : FewestPairs(rules.alpha);
  if (verdict.pairs < needed) {
    verdict.outcome = Outcome::kTooFewPairs;
    verdict.reason =
        fmt::format("{} pair{} of seeds; at least {} are needed", verdict.pairs, verdict.pairs == 1 ? "" : "s", needed);
  } else if (is_worse && verdict.worse_by > verdict.margin) {
    verdict.outcome = Outcome::kRegression;
  } else if (is_better && -verdict.worse_by > verdict.margin) {
    verdict.outcome = Outcome::kImprovement;
  }
  return verdict;
}

std::vector<LostRun> FindLost(const MeasuredEntry& before, const MeasuredEntry& now, const GateRules& rules) {
  std::vector<LostRun> lost;
  for (const MeasuredRun& run : before.runs) {
    const MeasuredRun* other = Find(now, run.seed);
    if (other == nullptr) continue;
    const std::string reason = LossReason(run, *other, rules);
    if (!reason.empty()) lost.push_back({run.seed, reason});
  }
  return lost;
}

MetricVerdict JudgeCoverage(const MeasuredEntry& before, const MeasuredEntry& now, const std::vector<LostRun>& lost,
                            const GateRules& rules) {
  const GatedMetric coverage{kCoverage, "", Better::kHigher, rules.coverage_margin, 0};
  MetricVerdict verdict = JudgePairs(coverage, PairCoverage(before, now), rules);
  if (int(lost.size()) <= rules.lost_runs_allowed) return verdict;
  verdict.outcome = Outcome::kRegression;
  verdict.reason = fmt::format("{} of {} runs lost; seed {}: {}", lost.size(), before.runs.size(), lost.front().seed,
                               lost.front().reason);
  return verdict;
}

}  // namespace

double MeasuredRun::Value(const std::string& metric) const {
  const auto there = values.find(metric);
  return there == values.end() ? kNaN : there->second;
}

std::string ToString(Outcome outcome) {
  switch (outcome) {
    case Outcome::kUnchanged: return "ok";
    case Outcome::kImprovement: return "improved";
    case Outcome::kRegression: return "REGRESSION";
    case Outcome::kTooFewPairs: return "TOO FEW PAIRS";
    case Outcome::kNotJudged: return "not judged";
  }
  return "";
}

int FewestPairs(double alpha) { return std::max(1, int(std::ceil(-std::log2(alpha) - 1e-9))); }

double LossOf(double value, Better better) {
  switch (better) {
    case Better::kLower: return value;
    case Better::kHigher: return -value;
    case Better::kNearOne: return std::abs(value - 1);
    case Better::kNearZero: return std::abs(value);
    case Better::kNeither: break;
  }
  GAITCAM_ASSERT(better != Better::kNeither);
  return value;
}

double LossOf(double value, const GatedMetric& metric) { return metric.change ? value : LossOf(value, metric.better); }

EntryVerdict JudgeEntry(const MeasuredEntry& before, const MeasuredEntry& now, const std::vector<GatedMetric>& metrics,
                        const GateRules& rules) {
  EntryVerdict entry{now.scenario, now.system, FindLost(before, now, rules), {}, {}};
  entry.metrics.push_back(JudgeCoverage(before, now, entry.lost, rules));
  const bool covered = entry.metrics.front().outcome != Outcome::kRegression;
  std::vector<Pairs> pairs_of;
  for (const GatedMetric& metric : metrics) {
    pairs_of.push_back(PairMetric(before, now, metric.name, entry.lost));
    entry.metrics.push_back(JudgePairs(metric, pairs_of.back(), rules));
  }
  entry.restless = RestlessSeeds(before, entry.metrics, rules);
  const auto is_restless = [&](uint64_t seed) {
    return std::find(entry.restless.begin(), entry.restless.end(), seed) != entry.restless.end();
  };
  for (size_t k = 0; k < metrics.size(); ++k) {
    const Pairs& pairs = pairs_of[k];
    MetricVerdict& verdict = entry.metrics[k + 1];
    JudgeSeeds(pairs, entry.restless, rules, verdict);
    if (!covered) {
      verdict.outcome = Outcome::kNotJudged;
      verdict.reason = "coverage was lost";
      continue;
    }
    const auto vanished = int(
        std::count_if(pairs.vanished.begin(), pairs.vanished.end(), [&](uint64_t seed) { return !is_restless(seed); }));
    if (vanished > std::max(rules.undetermined_allowed, rules.lost_runs_allowed)) {
      verdict.outcome = Outcome::kRegression;
      verdict.reason = fmt::format("{} of {} runs no longer determine it", vanished, before.runs.size());
    }
  }
  return entry;
}

bool HasRegressed(const EntryVerdict& entry) {
  return std::any_of(entry.metrics.begin(), entry.metrics.end(),
                     [](const MetricVerdict& m) { return m.outcome == Outcome::kRegression; });
}

bool HasRegressed(const std::vector<EntryVerdict>& entries) {
  return std::any_of(entries.begin(), entries.end(), [](const EntryVerdict& e) { return HasRegressed(e); });
}

bool HasImproved(const std::vector<EntryVerdict>& entries) {
  return std::any_of(entries.begin(), entries.end(), [](const EntryVerdict& entry) {
    return std::any_of(entry.metrics.begin(), entry.metrics.end(),
                       [](const MetricVerdict& m) { return m.outcome == Outcome::kImprovement; });
  });
}

int ExitCodeOf(const std::vector<EntryVerdict>& entries) {
  if (HasRegressed(entries)) return 1;
  for (const EntryVerdict& entry : entries) {
    for (const MetricVerdict& metric : entry.metrics) {
      if (metric.outcome == Outcome::kTooFewPairs) return 3;
    }
  }
  return entries.empty() ? 3 : 0;
}

}  // namespace gaitcam
