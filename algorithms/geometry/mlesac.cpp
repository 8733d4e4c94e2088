#include "algorithms/geometry/mlesac.h"

namespace gaitcam::internal {

MixtureFit FitMixture(const std::vector<double>& residuals2, double sigma, double span,
                      std::vector<double>& densities) {
  if (residuals2.empty()) return {0, 0};
  const double peak = 1 / (std::sqrt(2 * M_PI) * sigma), outlier = 1 / span;
  constexpr double kNegligible = 36;  // squared sigmas; exp(-18) is negligible beside the outliers' density
  for (size_t i = 0; i < residuals2.size(); ++i) {
    const double normalised2 = residuals2[i] / (sigma * sigma);
    densities[i] = normalised2 < kNegligible ? peak * std::exp(-0.5 * normalised2) : 0;
  }
  double gamma = 0.5;
  constexpr int kSteps = 5;
  for (int step = 0; step < kSteps; ++step) {  // EM (paper, section 4.1): expected inliers, then their share
    double inliers = 0;
    for (const double density : densities) {
      inliers += gamma * density / (gamma * density + (1 - gamma) * outlier);
    }
    gamma = std::clamp(inliers / double(densities.size()), 1e-3, 1 - 1e-3);
  }
  double sum = 0, product = 1;
  int factors = 0;
  constexpr int kFactors = 16;  // one logarithm for so many; densities lie far from the limits of a double
  for (const double density : densities) {
    product *= gamma * density + (1 - gamma) * outlier;
    if (++factors % kFactors == 0) {
      sum -= std::log(product);
      product = 1;
    }
  }
  return {sum - std::log(product), gamma};
}

}  // namespace gaitcam::internal
