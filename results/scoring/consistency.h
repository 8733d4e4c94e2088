/// Whether a system's covariances say how wrong its poses are: normalised estimation error squared (NEES).
///
/// Y. Bar-Shalom, X. R. Li and T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, 5.4:
/// e' P^-1 e of an error e of n dimensions with covariance P is chi-square distributed with n degrees of freedom. Here
/// it is divided by n = 6: 1 is right, more is overconfident, less is too cautious.

#pragma once

#include <cstdint>
#include <vector>

#include "results/scoring/association.h"

namespace gaitcam {

/// The 95 % band of one error of six dimensions, per dimension: chi-square quantiles 0.025 and 0.975 over 6.
constexpr double kNeesLow = 1.2373 / 6, kNeesHigh = 14.4494 / 6;

/// Quantiles of the chi-square distribution to both sides of its middle (Wilson and Hilferty 1931; to 1e-3 of them from
/// 30 degrees of freedom on).
struct ChiSquareInterval {
  double low = 0, high = 0;
  bool Contains(double sum) const { return sum >= low && sum <= high; }
};
/// @param normal_quantile 1.959964 for 95 %, 1.644854 for 90 %
ChiSquareInterval ChiSquareBand(int degrees, double normal_quantile = 1.959964);

struct NeesSample {
  int64_t stamp_ns = 0;
  double nees = 0;  ///< Per dimension.
};

/// Of every pose that has a covariance. The estimator's world is put where the truth has it at the first such pose, and
/// the error of that placing, which is that pose's own covariance moved to the present one, is added; of errors that
/// are common to both poses the difference counts. Lengths are taken as they are given: a system that does not know its
/// scale must say so by its covariance.
std::vector<NeesSample> AbsoluteNees(const std::vector<PosePair>& pairs);

/// Of the motion over `seconds` up to each such pose. What two poses share cancels: the covariance of the motion is
/// what the later pose has beyond the earlier one's, moved to it, without what each says is its own; and both of these.
/// Exact for an odometry, whose errors add up. Where it is not positive (a system that corrects itself and does not say
/// what is its own), the motion is left out.
std::vector<NeesSample> RelativeNees(const std::vector<PosePair>& pairs, double seconds);

/// The same from each frame to the next that is compared.
std::vector<NeesSample> FrameNees(const std::vector<PosePair>& pairs);

double MeanNees(const std::vector<NeesSample>& samples);     ///< NaN for none.
double ShareInBand(const std::vector<NeesSample>& samples);  ///< Of the samples within the 95 % band; NaN for none.

}  // namespace gaitcam
