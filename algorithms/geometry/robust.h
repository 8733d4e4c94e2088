/// Choice of the robust estimator by name.

#pragma once

#include "algorithms/core/errors.h"
#include "algorithms/geometry/mlesac.h"
#include "algorithms/geometry/preemptive_ransac.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {

/// The estimator that `options.estimator` names; arguments as of Ransac(). Scores of different estimators are not
/// comparable.
template <class Model, class Solve, class Residual2>
RansacResult<Model> EstimateRobustly(int n, int sample_size, const RansacOptions& options, RandomStream& random,
                                     Solve solve, Residual2 residual2, const std::vector<Model>& first_guesses = {}) {
  if (options.estimator == RobustEstimator::kMlesac) {
    return Mlesac<Model>(n, sample_size, options, random, solve, residual2, first_guesses);
  }
  if (options.estimator == RobustEstimator::kPreemptive) {
    return PreemptiveRansac<Model>(n, sample_size, options, random, solve, residual2, first_guesses);
  }
  GAITCAM_ASSERT(options.estimator == RobustEstimator::kRansac);
  return Ransac<Model>(n, sample_size, options, random, solve, residual2, first_guesses);
}

}  // namespace gaitcam
