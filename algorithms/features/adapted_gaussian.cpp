#include "algorithms/features/adapted_gaussian.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/features/spectrum.h"

namespace gaitcam {
namespace {

/// g(sigma) - g'(sigma') * h along the blur, at whole pixels, and its derivative by log sigma'. Across the blur both
/// sides of equation 5.15 have the same factor, so that one dimension says it all.
struct Residual {
  Eigen::ArrayXd value, slope;
};

double Normal(double x, double sigma) { return std::exp(-x * x / (2 * sigma * sigma)) / (std::sqrt(2 * M_PI) * sigma); }

Residual ResidualOf(double sigma, double extent, double adapted) {
  const int radius = int(std::ceil(extent / 2 + 4 * sigma));
  Residual r{Eigen::ArrayXd(2 * radius + 1), Eigen::ArrayXd(2 * radius + 1)};
  for (int i = -radius; i <= radius; ++i) {
    const double right = i + extent / 2, left = i - extent / 2;
    const double root = std::sqrt(2.0) * adapted;
    const double blurred = (std::erf(right / root) - std::erf(left / root)) / (2 * extent);
    r.value[i + radius] = Normal(i, sigma) - blurred;
    r.slope[i + radius] = (right * Normal(right, adapted) - left * Normal(left, adapted)) / extent;
  }
  return r;
}

}  // namespace

double AdaptedSigma(double sigma, double extent_px) {
  GAITCAM_ASSERT(sigma > 0 && extent_px >= 0);
  constexpr double kSharp_px = 1e-3;  // below this there is nothing to make up for
  constexpr double kMinShare = 0.05;  // part of sigma; a narrower Gaussian is a single sample
  constexpr double kConverged = 1e-9;
  if (extent_px < kSharp_px) return sigma;
  // Start where the variances add up: sigma'^2 + extent^2 / 12 = sigma^2.
  double x = std::log(std::sqrt(std::max(sigma * sigma - extent_px * extent_px / 12, sigma * sigma * 0.04)));
  const double lowest = std::log(kMinShare * sigma), highest = std::log(sigma);
  double damping = 1e-3;
  Residual r = ResidualOf(sigma, extent_px, std::exp(x));
  for (int i = 0; i < 100; ++i) {  // Levenberg-Marquardt in one unknown, log sigma'
    const double a = r.slope.square().sum(), g = (r.slope * r.value).sum();
    if (a < 1e-30) break;
    const double next = std::clamp(x - g / (a * (1 + damping)), lowest, highest);
    const Residual tried = ResidualOf(sigma, extent_px, std::exp(next));
    const bool better = tried.value.square().sum() < r.value.square().sum();
    damping = better ? damping / 10 : damping * 10;
    if (!better) {
      if (damping > 1e12) break;
      continue;
    }
    const double step = std::abs(next - x);
    x = next;
    r = tried;
    if (step < kConverged) break;
  }
  return std::exp(x);
}

double AdaptedSigmaCache::operator()(double sigma, double extent_px) {
  constexpr double kSteps = 20;  // per pixel of extent
  const int step = int(std::lround(extent_px * kSteps));
  const auto [place, is_new] = known_.try_emplace({sigma, step}, 0);
  if (is_new) place->second = AdaptedSigma(sigma, step / kSteps);
  return place->second;
}

ScaleSpace BuildAdaptedScaleSpace(const cv::Mat& image, const LineBlur& blur, const ScaleSpaceOptions& options,
                                  AdaptedSigmaCache& cache) {
  CheckFields(options);
  GAITCAM_ASSERT(!options.first_doubled);
  ScaleSpace space;
  if (image.empty()) return space;
  const std::vector<double> scales = LevelScales(options);
  constexpr int kMargin_px = 48;
  const Spectrum spectrum(image, kMargin_px);
  for (int o = 0; o < std::min(options.octaves, Spectrum::kMaxOctave + 1); ++o) {
    if (std::min(image.rows, image.cols) >> o < kMinOctavePx) break;
    ScaleOctave octave{double(1 << o), 0.0, {}};
    for (const double scale : scales) {
      const double sigma_px = scale * octave.pitch_px;  // in pixels of the image
      const double sigma = std::sqrt(std::max(sigma_px * sigma_px - options.camera_sigma * options.camera_sigma, 0.01));
      const double along = cache(sigma, blur.extent_px);
      octave.levels.push_back({scale, spectrum.Through(GaussianTransfer(along, sigma, blur.direction_rad), o)});
    }
    space.push_back(std::move(octave));
  }
  return space;
}

}  // namespace gaitcam
