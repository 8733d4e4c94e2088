#include "algorithms/estimation/resampling.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

std::vector<double> NormalisedWeights(const std::vector<double>& log_weights) {
  GAITCAM_ASSERT(!log_weights.empty());
  const double largest = *std::max_element(log_weights.begin(), log_weights.end());
  if (!std::isfinite(largest)) return std::vector<double>(log_weights.size(), 1.0 / double(log_weights.size()));
  std::vector<double> weights;
  double sum = 0;
  for (const double log_weight : log_weights) {
    weights.push_back(std::exp(log_weight - largest));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

double EffectiveSampleSize(const std::vector<double>& weights) {
  double squares = 0;
  for (const double weight : weights) squares += weight * weight;
  return 1 / squares;
}

std::vector<int> LowVarianceResample(const std::vector<double>& weights, int n, RandomStream& random) {
  GAITCAM_ASSERT(!weights.empty() && n > 0);
  std::vector<int> indices;
  const double step = 1.0 / n, start = step * random.Uniform();
  double cumulative = weights[0];
  int i = 0;
  for (int k = 0; k < n; ++k) {
    while (start + k * step >= cumulative && i + 1 < int(weights.size())) cumulative += weights[size_t(++i)];
    indices.push_back(i);
  }
  return indices;
}

}  // namespace gaitcam
