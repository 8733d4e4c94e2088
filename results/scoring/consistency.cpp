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

/// Without what errors common to all frames add to it.
Matrix6d CovarianceApart(const PosePair& pair) {
  return *pair.covariance - pair.common_errors * pair.common_errors.transpose();
}

/// What errors common to both poses add to the motion between them.
Matrix6d CovarianceInCommon(const PosePair& before, const PosePair& to, const Pose& estimate) {
  if (before.common_errors.cols() != to.common_errors.cols()) return Matrix6d::Zero();
  const CommonErrors difference = to.common_errors - Adjoint(estimate.Inverse()) * before.common_errors;
  return difference * difference.transpose();
}

/// What the earlier pose has of its own is not part of the later one's: it is added instead of being taken away.
std::optional<double> NeesOfMotion(const PosePair& before, const PosePair& to) {
  if (!to.covariance || !before.covariance) return std::nullopt;
  const Pose truth = before.truth.Inverse() * to.truth;
  const Pose estimate = before.estimate.Inverse() * to.estimate;
  Matrix6d shared = CovarianceApart(before);
  if (before.own_covariance) shared -= 2 * *before.own_covariance;
  return Nees(LogSe3(estimate.Inverse() * truth),
              CovarianceApart(to) - CarryCovariance(shared, estimate) + CovarianceInCommon(before, to, estimate));
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
    const Matrix6d covariance = CovarianceApart(pair) + CarryCovariance(CovarianceApart(*first), estimate) +
                                CovarianceInCommon(*first, pair, estimate);
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
    if (to.stamp_ns - before.stamp_ns < delta_ns - slack_ns) continue;
    if (const auto nees = NeesOfMotion(before, to)) samples.push_back({to.stamp_ns, *nees});
  }
  return samples;
}

std::vector<NeesSample> FrameNees(const std::vector<PosePair>& pairs) {
  std::vector<NeesSample> samples;
  for (size_t i = 1; i < pairs.size(); ++i) {
    if (const auto nees = NeesOfMotion(pairs[i - 1], pairs[i])) samples.push_back({pairs[i].stamp_ns, *nees});
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
