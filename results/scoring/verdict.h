/// Regression test of a system: current runs are compared with those of a baseline, paired by seed, so that differences
/// between seeds (path, floor, noise) cancel.
///
/// A metric regresses when the paired difference is both beyond its practical margin and significant; either alone is
/// noise, or too small to matter. A single seed that is far outside its own history is a regression as well: a median
/// over the seeds does not see it. Coverage is judged first: errors of a system that no longer covers the hard frames
/// say nothing, so where coverage regresses accuracy is not judged. What cannot be judged never passes.

#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "results/scoring/score.h"

namespace gaitcam {

enum class RunState { kScored, kNotScored, kCrashed };

/// What a gate keeps of one run.
struct MeasuredRun {
  uint64_t seed = 0;
  std::string hash;  ///< Of its resolved scenario.
  RunState state = RunState::kScored;
  std::string reason;                    ///< Why it is not scored, or how it crashed.
  std::map<std::string, double> values;  ///< The metrics that gate, by name; NaN where the run does not determine one.
  /// Of a baseline: the same of re-runs in which only the system's random stream differs.
  std::map<std::string, std::vector<double>> history;

  /// NaN if it is not there.
  double Value(const std::string& metric) const;
};

/// One system on one scenario, over the seeds.
struct MeasuredEntry {
  std::string scenario, system;
  std::vector<MeasuredRun> runs;
};

/// A metric that gates, and what difference is worth stopping for: the larger of the two margins.
struct GatedMetric {
  std::string name, unit;
  Better better = Better::kLower;  ///< Not kNeither.
  double margin = 0;               ///< In the metric's own unit.
  double margin_pct = 0;           ///< Of the baseline's median (of its distance from 1 or 0, if that is what counts).
  bool change = false;             ///< A change in either direction is a regression: of what has an error of its own
                                   ///< per seed, as a scale has whose camera height is known to 2 %.
};

/// Wilcoxon's signed-rank test, with the Hodges-Lehmann shift; or a bootstrap of the median.
enum class PairedTest { kSignedRank, kBootstrap };
constexpr auto WordsOf(PairedTest) {
  return std::array{EnumWord{PairedTest::kSignedRank, "signed_rank"}, EnumWord{PairedTest::kBootstrap, "bootstrap"}};
}

struct GateRules {
  using DescribedTag = void;
  PairedTest test =
      PairedTest::kSignedRank;  ///< Wilcoxon, with the Hodges-Lehmann shift; or a bootstrap of the median.
  double alpha = 0.01;
  int min_pairs = 0;
  double coverage_margin = 0.02;
  double lost_below = 0.5;
  int lost_runs_allowed = 0;
  int undetermined_allowed = 0;
  int history = 4;
  double seed_margins = 5;
};

template <class Visitor>
void VisitFields(Visitor& visit, GateRules& o) {
  visit("test", o.test, EnumWords<PairedTest>(),
        "Wilcoxon's signed-rank test with the Hodges-Lehmann shift, or a bootstrap of the median");
  visit("alpha", o.alpha, Between(1e-6, 0.5),
        "one-sided level of the test: chance of such a difference if nothing had changed");
  visit("min_pairs", o.min_pairs, Between(0, 100000), "fewer pairs are not judged; 0: the fewest that alpha needs");
  visit("coverage_margin", o.coverage_margin, Between(0.0, 1.0),
        "loss of coverage_ratio that matters; coverage_ratio always gates");
  visit("lost_below", o.lost_below, Between(0.0, 1.0),
        "a run that covers less than this part of what it covered before is lost");
  visit("lost_runs_allowed", o.lost_runs_allowed, Between(0, 100000),
        "more lost runs of one system on one scenario are a regression");
  visit("undetermined_allowed", o.undetermined_allowed, Between(0, 100000),
        "more runs that leave open what they determined before are a regression");
  visit("history", o.history, Between(0, 1000),
        "re-runs of each seed that a new baseline measures, with other random streams of the system: its own spread");
  visit("seed_margins", o.seed_margins, Between(0, 1e6),
        "a seed that is worse than all its history by more than so many margins is a regression; 0: is not judged");
}

enum class Outcome { kUnchanged, kImprovement, kRegression, kTooFewPairs, kNotJudged };
std::string ToString(Outcome outcome);

/// Median and range over the seeds; NaN if there is none.
struct Spread {
  double median = 0, low = 0, high = 0;
};

struct MetricVerdict {
  GatedMetric metric;
  Outcome outcome = Outcome::kUnchanged;
  std::string reason;   ///< Of what is neither unchanged nor plain from the numbers.
  Spread before, now;   ///< As the metric is.
  int pairs = 0;        ///< Seeds with a value before and now.
  int left_out = 0;     ///< Seeds without.
  double worse_by = 0;  ///< Paired shift: positive is worse, whatever the metric's direction. NaN without pairs.
  double margin = 0;    ///< That counted.
  double p_worse = 1;   ///< Chance of looking so much worse by luck. NaN for the bootstrap, which has an interval.
  double p_better = 1;  ///< ... better.
  Spread interval;      ///< Bootstrap only: the shift's interval at 1 - 2 alpha.
  int far_seeds = 0;    ///< Seeds far outside their own history.
};

/// A run that was scored in the baseline and is not any more, or that covers far less.
struct LostRun {
  uint64_t seed = 0;
  std::string reason;
};

struct EntryVerdict {
  std::string scenario, system;
  std::vector<LostRun> lost;
  std::vector<MetricVerdict> metrics;  ///< coverage_ratio first.
  std::vector<uint64_t> restless;      ///< Seeds not judged by themselves: their own re-runs spread too much.
};

/// The fewest pairs that a one-sided signed-rank test can find significant: 2^-n <= alpha.
int FewestPairs(double alpha);

/// What is minimized: the value, its negative, or its distance from 1 or 0.
double LossOf(double value, Better better);
/// The same of a gated metric; if any change counts, the value itself.
double LossOf(double value, const GatedMetric& metric);

/// @param metrics without coverage_ratio, which is judged always.
/// Runs are paired by seed, in whatever order they come; seeds that only one side has are left out.
EntryVerdict JudgeEntry(const MeasuredEntry& before, const MeasuredEntry& now, const std::vector<GatedMetric>& metrics,
                        const GateRules& rules);

bool HasRegressed(const EntryVerdict& entry);
bool HasRegressed(const std::vector<EntryVerdict>& entries);
bool HasImproved(const std::vector<EntryVerdict>& entries);

/// 0 pass (improvements pass as well), 1 regression, 3 nothing was judged, or something not.
int ExitCodeOf(const std::vector<EntryVerdict>& entries);

}  // namespace gaitcam
