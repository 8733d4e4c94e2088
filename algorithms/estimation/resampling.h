/// Resampling of weighted samples (particles).

#pragma once

#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {

/// Weights that sum to 1, from logarithms up to a common constant. All minus infinity: equal weights.
std::vector<double> NormalisedWeights(const std::vector<double>& log_weights);

/// Effective sample size 1 / sum w^2: from 1 (one sample has all weight) to their number. @param weights sum to 1.
double EffectiveSampleSize(const std::vector<double>& weights);

/// Low-variance (systematic) resampling: one random number, then equal steps through the cumulative weights, so that
/// sample i is drawn floor(n w_i) or ceil(n w_i) times.
/// @param weights sum to 1. @returns n indices in increasing order.
std::vector<int> LowVarianceResample(const std::vector<double>& weights, int n, RandomStream& random);

}  // namespace gaitcam
