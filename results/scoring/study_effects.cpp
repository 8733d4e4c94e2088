#include "results/scoring/study_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

/// How many of the ranks' subsets have a sum of at most `sum`, as a part of all: the signed-rank distribution.
std::vector<double> RankSumDistribution(int n) {
  std::vector<double> chance(size_t(n * (n + 1) / 2 + 1), 0.0);
  chance[0] = 1;
  for (int rank = 1, top = 0; rank <= n; ++rank) {
    top += rank;
    for (int sum = top; sum >= 0; --sum)
      chance[size_t(sum)] = 0.5 * (chance[size_t(sum)] + (sum >= rank ? chance[size_t(sum - rank)] : 0.0));
  }
  return chance;
}

/// How many of the sorted pair means lie outside each end.
int64_t RanksOutside(int64_t n, double confidence) {
  const double tail = 0.5 * (1 - confidence);
  constexpr int kExact = 50;
  if (n <= kExact) {
    const std::vector<double> chance = RankSumDistribution(int(n));
    double sum = 0;
    int64_t outside = 0;
    while (outside < int64_t(chance.size()) && (sum += chance[size_t(outside)]) <= tail) ++outside;
    return outside;
  }
  double low = 0, high = 40;  // the normal quantile, by bisection
  for (int i = 0; i < 100; ++i) {
    const double z = 0.5 * (low + high);
    (0.5 * std::erfc(z / std::sqrt(2.0)) > tail ? low : high) = z;
  }
  const double mean = 0.25 * double(n) * double(n + 1), variance = mean * double(2 * n + 1) / 6;
  return std::max<int64_t>(0, int64_t(std::floor(mean - low * std::sqrt(variance))));
}

/// The k-th smallest (from 0) mean of two of the sorted values, each with itself too. Their number grows with the
/// square, so they are counted, not listed: bisection finds the gap before it, then it is the least one beyond the gap.
double PairMean(const std::vector<double>& sorted, int64_t k) {
  const int64_t n = int64_t(sorted.size());
  const auto mean = [&](int64_t i, int64_t j) { return 0.5 * (sorted[size_t(i)] + sorted[size_t(j)]); };
  const auto count = [&](double limit) {  // pairs i <= j with a mean of at most `limit`
    int64_t pairs = 0;
    for (int64_t i = 0, j = n - 1; i <= j; ++i) {
      while (j >= i && mean(i, j) > limit) --j;
      pairs += j - i + 1;
    }
    return pairs;
  };
  double low = sorted.front(), high = sorted.back();
  if (count(low) > k) return low;
  for (int i = 0; i < 100 && low < high; ++i) {
    const double middle = low + 0.5 * (high - low);
    (count(middle) > k ? high : low) = middle;
  }
  double least = sorted.back();
  for (int64_t i = 0, j = n; i < n; ++i) {  // the first j of each i whose mean is beyond `low`
    while (j > i && mean(i, j - 1) > low) --j;
    const int64_t first = std::max(i, j);
    if (first < n && mean(i, first) > low) least = std::min(least, mean(i, first));
  }
  return least;
}

/// Scores that are best near a value are compared by their distance from it.
double Compared(const Score& metric, double value) {
  if (metric.better == Better::kNearOne) return std::abs(value - 1);
  if (metric.better == Better::kNearZero) return std::abs(value);
  return value;
}

/// Runs of one side of a comparison, by what pairs them.
using Side = std::map<std::pair<std::vector<size_t>, uint64_t>, double>;

Side SideOf(const StudyTable& table, const StudyEffect& effect, size_t level) {
  Side side;
  for (const StudyRun& run : table.runs) {
    if (run.levels[effect.axis] != level) continue;
    if (effect.within && run.levels[effect.within->first] != effect.within->second) continue;
    std::vector<size_t> others = run.levels;
    others[effect.axis] = 0;
    side[{others, run.seed}] = Compared(effect.metric, run.Value(effect.metric.name));
  }
  return side;
}

/// Values of runs, or of pairs of them, by their seed.
using BySeed = std::map<uint64_t, std::vector<double>>;

/// Percentile bootstrap of the median that draws whole seeds (cluster bootstrap).
ConfidenceInterval BootstrapSeeds(const BySeed& values, const StudyStatistics& statistics, RandomStream& random) {
  std::vector<const std::vector<double>*> seeds;
  for (const auto& [seed, of_seed] : values) seeds.push_back(&of_seed);
  std::vector<double> medians;
  for (int i = 0; i < statistics.resamples && !seeds.empty(); ++i) {
    std::vector<double> drawn;
    for (size_t k = 0; k < seeds.size(); ++k) {
      const std::vector<double>& of_seed = *seeds[size_t(random.Index(int(seeds.size())))];
      drawn.insert(drawn.end(), of_seed.begin(), of_seed.end());
    }
    medians.push_back(MedianOf(std::move(drawn)));
  }
  return {QuantileOf(medians, (1 - statistics.confidence) / 2), QuantileOf(medians, (1 + statistics.confidence) / 2)};
}

void Measure(const StudyTable& table, double confidence, StudyEffect& effect) {
  const Side reference = SideOf(table, effect, table.axes[effect.axis].reference);
  std::vector<double> references;
  BySeed changes;
  for (const auto& [key, value] : SideOf(table, effect, effect.level)) {
    const auto other = reference.find(key);
    const double before = other == reference.end() ? kNaN : other->second;
    if (!std::isfinite(value - before)) {
      ++effect.unpaired;
      continue;
    }
    changes[key.second].push_back(value - before);
    references.push_back(before);
  }
  std::vector<double> differences;  // one per seed: its pairs share the walk
  for (const auto& [seed, values] : changes) differences.push_back(MedianOf(values));
  effect.pairs = references.size();
  effect.walks = differences.size();
  effect.reference = MedianOf(references);
  effect.ends = ShiftInterval(differences, confidence);
  std::sort(differences.begin(), differences.end());
  const int64_t means = int64_t(effect.walks) * (int64_t(effect.walks) + 1) / 2;
  effect.shift = means == 0 ? kNaN : 0.5 * (PairMean(differences, (means - 1) / 2) + PairMean(differences, means / 2));
  effect.p = differences.empty() ? 1 : TestSignedRanks(differences).p_two_sided;
}

double Part(const StudyEffect& effect) {
  const double part = std::abs(effect.shift / effect.reference);
  return std::isfinite(part) ? part : 0;
}

std::string LevelsOf(const StudyTable& table, const StudyRun& run) {
  std::string text;
  for (size_t a = 0; a < table.axes.size(); ++a) text += table.axes[a].levels[run.levels[a]] + ",";
  return text;
}

}  // namespace

ConfidenceInterval ShiftInterval(const std::vector<double>& differences, double confidence) {
  std::vector<double> sorted = differences;
  std::sort(sorted.begin(), sorted.end());
  const int64_t n = int64_t(sorted.size()), outside = n == 0 ? 0 : RanksOutside(n, confidence);
  if (outside < 1) return {kNaN, kNaN};
  return {PairMean(sorted, outside - 1), PairMean(sorted, n * (n + 1) / 2 - outside)};
}

MedianRow SummarizeRuns(const std::vector<const StudyRun*>& runs, const std::string& score,
                        const StudyStatistics& statistics, const std::string& label) {
  std::vector<double> values;
  BySeed by_seed;
  for (const StudyRun* run : runs) {
    const double value = run->Value(score);
    if (!std::isfinite(value)) continue;
    values.push_back(value);
    by_seed[run->seed].push_back(value);
  }
  RandomStream random(1, "study/" + label + "/" + score);
  return {values.size(), runs.size(), by_seed.size(), MedianOf(values), BootstrapSeeds(by_seed, statistics, random)};
}

std::string SummaryCsv(const StudyTable& table, const StudyStatistics& statistics) {
  std::string text;
  for (const StudyAxis& axis : table.axes) text += CsvField(axis.key) + ",";
  text += "metric,unit,runs,n,median,low,high\n";
  for (size_t first = 0; first < table.runs.size(); first += table.seeds) {
    std::vector<const StudyRun*> runs;
    for (size_t i = first; i < first + table.seeds; ++i) runs.push_back(&table.runs[i]);
    for (const Score& metric : table.metrics) {
      const MedianRow row = SummarizeRuns(runs, metric.name, statistics, LevelsOf(table, *runs.front()));
      for (size_t a = 0; a < table.axes.size(); ++a)
        text += CsvField(table.axes[a].levels[runs.front()->levels[a]]) + ",";
      text += fmt::format("{},{},{},{},{},{},{}\n", metric.name, metric.unit, row.runs, row.n, CsvNumber(row.median),
                          CsvNumber(row.interval.low), CsvNumber(row.interval.high));
    }
  }
  return text;
}

int StudyEffect::Verdict(double confidence) const {
  if (!(p_holm < 1 - confidence) || metric.better == Better::kNeither || shift == 0) return 0;
  return (shift > 0) == (metric.better == Better::kHigher) ? 1 : -1;
}

std::vector<StudyEffect> RankEffects(const StudyTable& table, const StudyStatistics& statistics,
                                     std::optional<size_t> by) {
  std::vector<StudyEffect> effects;
  for (size_t axis = 0; axis < table.axes.size(); ++axis) {
    std::vector<std::optional<std::pair<size_t, size_t>>> strata{std::nullopt};
    if (by && *by != axis) {
      for (size_t level = 0; level < table.axes[*by].levels.size(); ++level) strata.push_back(std::pair(*by, level));
    }
    for (size_t level = 0; level < table.axes[axis].levels.size(); ++level) {
      if (level == table.axes[axis].reference) continue;
      for (const auto& within : strata) {
        for (const Score& metric : table.metrics) {
          StudyEffect& effect = effects.emplace_back();
          effect.axis = axis;
          effect.level = level;
          effect.within = within;
          effect.metric = metric;
          Measure(table, statistics.confidence, effect);
        }
      }
    }
  }
  std::vector<double> p;
  for (const StudyEffect& effect : effects) p.push_back(effect.p);
  const std::vector<double> adjusted = HolmAdjusted(p);
  for (size_t i = 0; i < effects.size(); ++i) effects[i].p_holm = adjusted[i];
  std::stable_sort(effects.begin(), effects.end(), [](const StudyEffect& a, const StudyEffect& b) {
    return std::tuple(a.p_holm, a.p, -Part(a)) < std::tuple(b.p_holm, b.p, -Part(b));
  });
  return effects;
}

std::string EffectText(const StudyTable& table, const StudyEffect& effect) {
  const auto name = [&](size_t axis) { return table.axes[axis].key.substr(table.axes[axis].key.rfind('.') + 1); };
  const StudyAxis& axis = table.axes[effect.axis];
  std::string text =
      fmt::format("{}={} vs {}", name(effect.axis), axis.levels[effect.level], axis.levels[axis.reference]);
  if (effect.within) {
    text += fmt::format(", {}={}", name(effect.within->first),
                        table.axes[effect.within->first].levels[effect.within->second]);
  }
  return text;
}

size_t SeedsForASureEffect(size_t comparisons, double confidence) {
  size_t seeds = 1;
  while (std::ldexp(double(comparisons), 1 - int(seeds)) >= 1 - confidence) ++seeds;
  return seeds;
}

std::string TooFewSeeds(const std::vector<StudyEffect>& effects, double confidence) {
  size_t walks = 0;
  for (const StudyEffect& effect : effects) walks = std::max(walks, effect.walks);
  const size_t enough = SeedsForASureEffect(effects.size(), confidence);
  if (walks == 0 || walks >= enough) return "";
  return fmt::format(
      "No comparison can be sure: with {} seeds p is {:.2g} at best, before the correction for {} comparisons. "
      "{} seeds can make one sure.",
      walks, std::ldexp(1.0, 1 - int(walks)), effects.size(), enough);
}

std::string EffectsCsv(const StudyTable& table, const std::vector<StudyEffect>& effects) {
  std::string text =
      "rank,axis,level,reference_level,within,metric,unit,pairs,unpaired,walks,reference_median,shift,low,high,p,"
      "p_holm\n";
  int rank = 0;
  for (const StudyEffect& e : effects) {
    const StudyAxis& axis = table.axes[e.axis];
    const std::string within =
        e.within ? table.axes[e.within->first].key + "=" + table.axes[e.within->first].levels[e.within->second] : "";
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", ++rank, CsvField(axis.key),
                        CsvField(axis.levels[e.level]), CsvField(axis.levels[axis.reference]), CsvField(within),
                        e.metric.name, e.metric.unit, e.pairs, e.unpaired, e.walks, CsvNumber(e.reference),
                        CsvNumber(e.shift), CsvNumber(e.ends.low), CsvNumber(e.ends.high), CsvNumber(e.p),
                        CsvNumber(e.p_holm));
  }
  return text;
}

}  // namespace gaitcam
