/// MLESAC (Torr and Zisserman, CVIU 78, 2000): as RANSAC samples, but a hypothesis is judged by the likelihood of all
/// data under a mixture of Gaussian inliers and uniform outliers, whose mixing parameter EM finds for each hypothesis.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "algorithms/geometry/ransac.h"

namespace gaitcam {
namespace internal {

/// Minus the logarithm of the likelihood of residuals under gamma N(0, sigma^2) + (1 - gamma) / span, with the gamma
/// that maximises it.
struct MixtureFit {
  double minus_log_likelihood = std::numeric_limits<double>::infinity();
  double gamma = 0;
};

/// @param densities scratch space, one entry per datum
MixtureFit FitMixture(const std::vector<double>& residuals2, double sigma, double span, std::vector<double>& densities);

}  // namespace internal

/// @param options threshold: 1.96 sigma of an inlier's residual (95 % of inliers);
///                outlier_span: the range of an outlier's residual
/// The score of the result is minus the log-likelihood; else as Ransac().
template <class Model, class Solve, class Residual2>
RansacResult<Model> Mlesac(int n, int sample_size, const RansacOptions& options, RandomStream& random, Solve solve,
                           Residual2 residual2, const std::vector<Model>& first_guesses = {}) {
  RansacResult<Model> best;
  best.score = std::numeric_limits<double>::infinity();
  constexpr double kSigmas = 1.96;
  const double limit2 = options.threshold * options.threshold;
  int needed = options.max_iterations;
  const int min_samples = std::min(options.min_iterations, options.max_iterations);
  std::vector<double> residuals2(static_cast<size_t>(n)), densities(residuals2);
  const auto judge = [&](const Model& model) {
    for (int i = 0; i < n; ++i) residuals2[size_t(i)] = residual2(model, i);
    const internal::MixtureFit fit =
        internal::FitMixture(residuals2, options.threshold / kSigmas, options.outlier_span, densities);
    if (!(fit.minus_log_likelihood < best.score)) return;
    best.score = fit.minus_log_likelihood;
    best.model = model;
    best.inliers.clear();
    for (int i = 0; i < n; ++i) {
      if (residuals2[size_t(i)] < limit2) best.inliers.push_back(i);
    }
    needed = std::max(min_samples,
                      internal::SamplesNeeded(fit.gamma, sample_size, options.confidence, options.max_iterations));
  };
  for (const Model& model : first_guesses) judge(model);
  if (n < sample_size) return best;
  for (; best.iterations < needed; ++best.iterations) {
    for (const Model& model : solve(internal::DrawSample(n, sample_size, random))) judge(model);
  }
  return best;
}

}  // namespace gaitcam
