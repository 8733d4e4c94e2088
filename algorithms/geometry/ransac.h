/// Random sample consensus (Fischler and Bolles 1981) with a truncated-square score (MSAC, Torr and Zisserman 2000).

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/random.h"

namespace gaitcam {

enum class RobustEstimator { kRansac, kMlesac, kPreemptive };
constexpr auto WordsOf(RobustEstimator) {
  return std::array{EnumWord{RobustEstimator::kRansac, "ransac"}, EnumWord{RobustEstimator::kMlesac, "mlesac"},
                    EnumWord{RobustEstimator::kPreemptive, "preemptive"}};
}

/// Of all estimators behind EstimateRobustly (robust.h).
struct RansacOptions {
  double threshold = 0.005;    ///< Maximum residual of an inlier, in the residual's unit.
  double confidence = 0.9999;  ///< Probability of at least one sample without outliers.
  int max_iterations = 300;
  int min_iterations = 20;  ///< So that noise does not decide between models with the same inliers.
  RobustEstimator estimator = RobustEstimator::kRansac;  ///< Ignored by Ransac().
  double outlier_span = 1.0;  ///< mlesac: residuals of mismatches are uniform over this range.
  int block = 100;            ///< preemptive: data scored between two halvings of the hypotheses.
};

/// A model and its inliers; none: no model was found.
template <class Model>
struct RansacResult {
  Model model;
  std::vector<int> inliers;  ///< Indices in increasing order.
  double score = 0;          ///< Sum over all data of min(residual^2, threshold^2); smaller is better.
  int iterations = 0;
};

namespace internal {

/// Draws `count` different indices below n, in the order drawn.
std::vector<int> DrawSample(int n, int count, RandomStream& random);

/// Samples that reach `confidence` of one without outliers (Fischler and Bolles, section II.B).
int SamplesNeeded(double inlier_ratio, int sample_size, double confidence, int max_samples);

}  // namespace internal

/// @param n             number of data, of which `sample_size` determine a few candidate models
/// @param solve         (const std::vector<int>& sample) -> std::vector<Model>
/// @param residual2     (const Model&, int datum) -> squared residual (infinity where the datum contradicts the model)
/// @param first_guesses models to be judged before any sample is drawn
/// All randomness comes from `random`: same stream state and data, same result.
template <class Model, class Solve, class Residual2>
RansacResult<Model> Ransac(int n, int sample_size, const RansacOptions& options, RandomStream& random, Solve solve,
                           Residual2 residual2, const std::vector<Model>& first_guesses = {}) {
  RansacResult<Model> best;
  const double limit2 = options.threshold * options.threshold;
  best.score = n * limit2;
  int needed = options.max_iterations;
  const int min_samples = std::min(options.min_iterations, options.max_iterations);
  const auto judge = [&](const Model& model) {
    double score = 0;
    for (int i = 0; i < n; ++i) {
      score += std::min(residual2(model, i), limit2);
      if (score >= best.score) return;
    }
    best.score = score;
    best.model = model;
    best.inliers.clear();
    for (int i = 0; i < n; ++i) {
      if (residual2(model, i) < limit2) best.inliers.push_back(i);
    }
    needed = std::max(min_samples, internal::SamplesNeeded(double(best.inliers.size()) / n, sample_size,
                                                           options.confidence, options.max_iterations));
  };
  for (const Model& model : first_guesses) judge(model);
  if (n < sample_size) return best;
  for (; best.iterations < needed; ++best.iterations) {
    for (const Model& model : solve(internal::DrawSample(n, sample_size, random))) judge(model);
  }
  return best;
}

}  // namespace gaitcam
