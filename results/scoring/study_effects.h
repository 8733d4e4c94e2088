/// Statistics of a study: medians with confidence intervals, and paired effects of each factor.
///
/// The independent unit is the seed: all runs of one seed share its walk, or at least its start, scene and noise,
/// whatever system, exposure or gait they differ in. They are one cluster. Intervals of medians draw whole seeds;
/// effects are one number per seed, the median over its pairs, and tests and intervals go over these.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "results/scoring/statistics.h"
#include "results/scoring/study_table.h"

namespace gaitcam {

struct StudyStatistics {
  double confidence = 0.95;  ///< Of all intervals.
  int resamples = 2000;      ///< Of bootstrap intervals.
};

/// A median over the runs that have the score.
struct MedianRow {
  size_t n = 0;      ///< Runs that have it,
  size_t runs = 0;   ///< of so many.
  size_t walks = 0;  ///< Seeds among those that have it: independent ones.
  double median = 0;
  ConfidenceInterval interval;  ///< Percentile bootstrap over seeds (cluster bootstrap); a point if there is only one.
};

/// Median of a score over some runs. `label` names the random stream: the same runs have the same interval.
MedianRow SummarizeRuns(const std::vector<const StudyRun*>& runs, const std::string& score,
                        const StudyStatistics& statistics, const std::string& label);

/// summary.csv: one row per condition and metric, over the seeds. Columns after the axes: metric, unit, runs, n (runs
/// that have the score), median, low and high (bootstrap over seeds).
std::string SummaryCsv(const StudyTable& table, const StudyStatistics& statistics);

/// One axis's level against its reference level, paired by seed and by the levels of all other axes.
struct StudyEffect {
  size_t axis = 0, level = 0;
  std::optional<std::pair<size_t, size_t>> within;  ///< Only runs of this other axis and level of it.
  Score metric;
  size_t pairs = 0;         ///< Pairs in which both have the score,
  size_t unpaired = 0;      ///< and in which one or both do not.
  size_t walks = 0;         ///< Seeds among the pairs: what the numbers below are computed over.
  double reference = 0;     ///< Median of the reference runs of the pairs.
  double shift = 0;         ///< Hodges-Lehmann, of the seeds' changes from the reference to the level.
  ConfidenceInterval ends;  ///< Of the shift, by inverting the signed-rank test; NaN if there are too few seeds for it.
  double p = 1;             ///< Wilcoxon's signed-rank test over seeds, two-sided; 1 without pairs.
  double p_holm = 1;        ///< Corrected for all effects of the study.

  /// -1 worse, 1 better, 0 not significant at 1 - confidence or neither.
  int Verdict(double confidence) const;
};

/// All effects, the surest first, then the largest part of the reference. Scores that are best near 1 or 0 are compared
/// by their distance from it. If `by` names an axis, each effect of the others stands also within each of its levels.
std::vector<StudyEffect> RankEffects(const StudyTable& table, const StudyStatistics& statistics,
                                     std::optional<size_t> by);

/// effects.csv, in the order given. Columns: rank, axis, level, reference_level, within, metric, unit, pairs, unpaired,
/// walks (independent ones: seeds), reference_median, shift, low, high, p, p_holm; the last five are computed over
/// walks.
std::string EffectsCsv(const StudyTable& table, const std::vector<StudyEffect>& effects);

/// "exposure=20 vs 0", "exposure=20 vs 0, system=sift_vo".
std::string EffectText(const StudyTable& table, const StudyEffect& effect);

/// Seeds of which all must agree for the surest of so many comparisons to be sure: with n of them p is 2^(1-n) at
/// least, Holm multiplies it by their number.
size_t SeedsForASureEffect(size_t comparisons, double confidence);

/// One sentence where there are fewer seeds than that, so that nothing can be sure whatever the scores are; else empty.
std::string TooFewSeeds(const std::vector<StudyEffect>& effects, double confidence);

/// Interval of the shift that belongs to the signed-rank test (Hollander & Wolfe, 3.3): order statistics of the means
/// of all pairs of differences. NaN where no such interval reaches the confidence (fewer than 6 differences for 95 %).
ConfidenceInterval ShiftInterval(const std::vector<double>& differences, double confidence);

}  // namespace gaitcam
