/// Preemptive RANSAC (D. Nister, ICCV 2003): a fixed number of hypotheses is scored breadth first, one block of data at
/// a time in random order, and the worse half is dropped after each. The time is bounded for all data.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "algorithms/geometry/ransac.h"

namespace gaitcam {

/// @param options max_iterations: samples drawn (all their models are hypotheses); block; threshold: sigma of the
///                Cauchy log-likelihood log(1 + residual^2 / sigma^2) is 1 / 1.96 of it
/// The score of the result is minus the log-likelihood over all data; else as Ransac().
template <class Model, class Solve, class Residual2>
RansacResult<Model> PreemptiveRansac(int n, int sample_size, const RansacOptions& options, RandomStream& random,
                                     Solve solve, Residual2 residual2, const std::vector<Model>& first_guesses = {}) {
  struct Hypothesis {
    Model model;
    double score;
    int order;
  };
  RansacResult<Model> best;
  std::vector<Hypothesis> hypotheses;
  for (const Model& model : first_guesses) hypotheses.push_back({model, 0, int(hypotheses.size())});
  for (; n >= sample_size && best.iterations < options.max_iterations; ++best.iterations) {
    for (const Model& model : solve(internal::DrawSample(n, sample_size, random))) {
      hypotheses.push_back({model, 0, int(hypotheses.size())});
    }
  }
  if (hypotheses.empty()) return best;
  std::vector<int> order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  for (int i = n - 1; i > 0; --i) std::swap(order[size_t(i)], order[size_t(random.Index(i + 1))]);
  constexpr double kSigmas = 1.96;
  const double sigma2 = std::pow(options.threshold / kSigmas, 2);
  const auto better = [](const Hypothesis& a, const Hypothesis& b) {
    return a.score != b.score ? a.score < b.score : a.order < b.order;
  };
  for (int begin = 0; begin < n; begin += options.block) {
    const int end = std::min(n, begin + options.block);
    for (Hypothesis& h : hypotheses) {
      for (int k = begin; k < end; ++k) h.score += std::log1p(residual2(h.model, order[size_t(k)]) / sigma2);
    }
    const size_t keep = std::max<size_t>(1, hypotheses.size() / 2);  // f(i) = M 2^-floor(i / block), equation 11
    std::nth_element(hypotheses.begin(), hypotheses.begin() + long(keep - 1), hypotheses.end(), better);
    if (end < n) hypotheses.resize(keep);
  }
  const Hypothesis& winner = *std::min_element(hypotheses.begin(), hypotheses.end(), better);
  best.model = winner.model;
  best.score = winner.score;
  const double limit2 = options.threshold * options.threshold;
  for (int i = 0; i < n; ++i) {
    if (residual2(best.model, i) < limit2) best.inliers.push_back(i);
  }
  return best;
}

}  // namespace gaitcam
