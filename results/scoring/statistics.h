/// The statistics of paired comparisons: what a difference is worth when few seeds were run.

#pragma once

#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {

/// Median, the mean of the two middle values of an even number. @returns NaN for none.
double MedianOf(std::vector<double> values);

/// Linear interpolation between order statistics (Hyndman & Fan type 7). @returns NaN for none.
double QuantileOf(std::vector<double> values, double fraction);

/// Wilcoxon's signed-rank test of paired differences against a median of 0. Zero differences are left out, ties get
/// mean ranks; the distribution of the rank sum is exact (by enumeration over the ranks as they are) up to 50 pairs,
/// normal with continuity correction beyond.
struct SignedRankTest {
  int pairs = 0;         ///< Differences that are not zero.
  double p_greater = 1;  ///< Chance of a rank sum at least as large if the median were 0.
  double p_less = 1;
  double p_two_sided = 1;
};
SignedRankTest TestSignedRanks(const std::vector<double>& differences);

/// Median of the means of all pairs of differences, each with itself too (Hodges & Lehmann 1963): the estimate of the
/// shift that belongs to the signed-rank test. @returns NaN for none.
double HodgesLehmann(const std::vector<double>& differences);

/// Percentile bootstrap interval of the median (Efron 1979). NaN for no values.
struct ConfidenceInterval {
  double low = 0, high = 0;
};
ConfidenceInterval BootstrapMedian(const std::vector<double>& values, double confidence, int resamples,
                                   RandomStream& random);

/// Holm's step-down correction: p-values that hold for all comparisons together, in the order given.
std::vector<double> HolmAdjusted(const std::vector<double>& p);

}  // namespace gaitcam
