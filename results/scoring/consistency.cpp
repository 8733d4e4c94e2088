#include "results/scoring/consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

/// Nothing if the covariance is not positive definite.
std::optional<double> Nees(const Vector6d& error, const Matrix6d& covariance) {
  const Eigen::LLT<Matrix6d> cholesky(0.5 * (covariance + covariance.transpose()));
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return error.dot(cholesky.solve(error)) / 6;
}

/// A covariance of X_WA as one of X_WB, if B stands rigidly to A: tangents are moved by Ad(X_BA).
Matrix6d Carry(const Matrix6d& covariance, const Pose& X_AB) {
  const Matrix6d adjoint = Adjoint(X_AB.Inverse());
  return adjoint * covariance * adjoint.transpose();
}

}  // namespace

ChiSquareInterval ChiSquareBand(int degrees, double normal_quantile) {
  const double variance = 2.0 / (9.0 * degrees);  // of the cube root of chi-square over its degrees
  const auto at = [&](double quantile) { return degrees * std::pow(1 - variance + quantile * std::sqrt(variance), 3); };
  return {at(-normal_quantile), at(normal_quantile)};
}

std::vector<NeesSample> AbsoluteNees(const std::vector<PosePair>& pairs) {
  std::vector<NeesSample> samples;
  const PosePair* first = nullptr;
  for (const PosePair& pair : pairs) {
    if (!pair.covariance) continue;
    if (first == nullptr) {
      first = &pair;
      continue;
    }
    const Pose truth = first->truth.Inverse() * pair.truth;
    const Pose estimate = first->estimate.Inverse() * pair.estimate;
    const Matrix6d covariance = *pair.covariance + Carry(*first->covariance, estimate);
    if (const auto nees = Nees(LogSe3(estimate.Inverse() * truth), covariance)) {
      samples.push_back({pair.stamp_ns, *nees});
    }
  }
  return samples;
}

std::vector<NeesSample> RelativeNees(const std::vector<PosePair>& pairs, double seconds) {
  std::vector<NeesSample> samples;
  const int64_t delta_ns = std::llround(1e9 * seconds), slack_ns = delta_ns / 10;
  size_t from = 0;
  for (const PosePair& to : pairs) {
    while (to.stamp_ns - pairs[from].stamp_ns > delta_ns + slack_ns) ++from;
    const PosePair& before = pairs[from];
    if (to.stamp_ns - before.stamp_ns < delta_ns - slack_ns || !to.covariance || !before.covariance) continue;
    const Pose truth = before.truth.Inverse() * to.truth;
    const Pose estimate = before.estimate.Inverse() * to.estimate;
    const Matrix6d covariance = *to.covariance - Carry(*before.covariance, estimate);
    if (const auto nees = Nees(LogSe3(estimate.Inverse() * truth), covariance)) {
      samples.push_back({to.stamp_ns, *nees});
    }
  }
  return samples;
}

double MeanNees(const std::vector<NeesSample>& samples) {
  double sum = 0;
  for (const NeesSample& sample : samples) sum += sample.nees;
  return samples.empty() ? kNaN : sum / double(samples.size());
}

double ShareInBand(const std::vector<NeesSample>& samples) {
  const auto inside = std::count_if(samples.begin(), samples.end(), [](const NeesSample& sample) {
    return sample.nees >= kNeesLow && sample.nees <= kNeesHigh;
  });
  return samples.empty() ? kNaN : double(inside) / double(samples.size());
}

}  // namespace gaitcam
