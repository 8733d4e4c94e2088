#include "algorithms/features/psf_spectral.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kLeastSide = 64;
constexpr int kBins = 128;             ///< Of frequency along a direction.
constexpr double kExtentStep = 0.25;   ///< px, of the table.
constexpr double kNullFloor = 0.003;   ///< A null is never seen deeper than this, for leakage and noise.
constexpr int kCoarseDirections = 60;  ///< Every 3 degrees.
constexpr int kCandidates = 4;

double SincSquared(double x) {
  if (std::abs(x) < 1e-6) return 1;
  const double s = std::sin(M_PI * x) / (M_PI * x);
  return s * s;
}

}  // namespace

LineSpectra::LineSpectra(double min_extent_px, double max_extent_px, double high_frequency)
    : min_extent_px_(min_extent_px),
      bins_per_frequency_(kBins / high_frequency),
      bins_(kBins),
      extents_(int((max_extent_px - min_extent_px) / kExtentStep) + 1),
      log_power_(size_t(extents_) * size_t(kBins)) {
  constexpr int kTaps = 5;  // a bin holds a range of frequencies
  for (int e = 0; e < extents_; ++e) {
    const double extent = min_extent_px + e * kExtentStep;
    for (int b = 0; b < bins_; ++b) {
      double sum = 0;
      for (int t = 0; t < kTaps; ++t) sum += SincSquared(extent * (b + (t + 0.5) / kTaps) / bins_per_frequency_);
      log_power_[size_t(e) * size_t(bins_) + size_t(b)] = float(std::log(sum / kTaps + kNullFloor));
    }
  }
}

LineSpectra::Profile LineSpectra::Project(const std::vector<SpectrumSample>& samples, double direction_rad) const {
  Profile profile{std::vector<float>(size_t(bins_), 0.0f), std::vector<float>(size_t(bins_), 0.0f)};
  const float c = float(std::cos(direction_rad) * bins_per_frequency_);
  const float s = float(std::sin(direction_rad) * bins_per_frequency_);
  for (const SpectrumSample& sample : samples) {
    const int bin = std::min(bins_ - 1, int(std::abs(sample.fx * c + sample.fy * s)));
    profile.sum[size_t(bin)] += sample.value;
    profile.count[size_t(bin)] += 1.0f;
  }
  return profile;
}

LineSpectra::Fit LineSpectra::Best(const Profile& profile) const {
  float total = 0;
  for (const float n : profile.count) total += n;
  std::vector<float> scores(static_cast<size_t>(extents_));
  for (int e = 0; e < extents_; ++e) {
    const float* model = log_power_.data() + size_t(e) * size_t(bins_);
    float dot = 0, sum = 0, squares = 0;
    for (int b = 0; b < bins_; ++b) {
      dot += profile.sum[size_t(b)] * model[b];
      sum += profile.count[size_t(b)] * model[b];
      squares += profile.count[size_t(b)] * model[b] * model[b];
    }
    const float variance = squares / total - (sum / total) * (sum / total);
    scores[size_t(e)] = variance > 0 ? dot / total / std::sqrt(variance) : -1.0f;
  }
  const int best = int(std::max_element(scores.begin(), scores.end()) - scores.begin());
  Fit fit;
  fit.correlation = double(scores[size_t(best)]);
  double offset = 0;
  if (best > 0 && best + 1 < extents_) {
    const double before = double(scores[size_t(best - 1)]), after = double(scores[size_t(best + 1)]);
    const double curvature = before - 2 * fit.correlation + after;
    if (curvature < 0) offset = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
  }
  fit.extent_px = min_extent_px_ + (best + offset) * kExtentStep;
  return fit;
}

SpectralPsf::SpectralPsf(const SpectralOptions& options)
    : options_(options), spectra_(options.min_extent_px, options.max_extent_px, options.high_frequency) {
  CheckFields(options_);
  if ((options_.window_px & (options_.window_px - 1)) != 0) throw BadOption("window_px: must be a power of two");
}

BlurEstimate SpectralPsf::Estimate(const cv::Mat& grey, const cv::Rect& region) const {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  const cv::Rect seen = region & cv::Rect({0, 0}, grey.size());
  if (seen.width < kLeastSide || seen.height < kLeastSide) return {};
  int window = options_.window_px;
  while (window > 64 && window / 2 >= std::max(seen.width, seen.height)) window /= 2;
  PowerSpectrum spectrum(window);
  spectrum.Add(Laplacian(grey(seen)));
  if (spectrum.empty()) return {};

  const auto fit_at = [&](const std::vector<SpectrumSample>& samples, double direction) {
    LineSpectra::Fit fit = spectra_.Best(spectra_.Project(samples, direction));
    fit.direction_rad = direction;
    return fit;
  };
  const std::vector<SpectrumSample> coarse =
      WhitenSpectrum(spectrum.Halved(), options_.low_frequency, options_.high_frequency);
  std::vector<LineSpectra::Fit> fits;
  for (int i = 0; i < kCoarseDirections; ++i) fits.push_back(fit_at(coarse, M_PI * i / kCoarseDirections));
  std::stable_sort(fits.begin(), fits.end(),
                   [](const auto& a, const auto& b) { return a.correlation > b.correlation; });

  const std::vector<SpectrumSample> fine = WhitenSpectrum(spectrum, options_.low_frequency, options_.high_frequency);
  LineSpectra::Fit best;
  for (int k = 0; k < kCandidates; ++k) {
    LineSpectra::Fit here = fit_at(fine, fits[size_t(k)].direction_rad);
    for (double step = 1.5 * M_PI / 180; step > 0.1 * M_PI / 180; step /= 2) {
      const double middle = here.direction_rad;
      for (const double side : {-step, step}) {
        const LineSpectra::Fit there = fit_at(fine, middle + side);
        if (there.correlation > here.correlation) here = there;
      }
    }
    if (here.correlation > best.correlation) best = here;
  }
  BlurEstimate estimate;
  estimate.blur = {best.extent_px, std::fmod(best.direction_rad + M_PI, M_PI)};
  estimate.confidence = std::clamp(best.correlation, 0.0, 1.0);
  estimate.blurred = estimate.blur.extent_px >= options_.verdict_px && estimate.confidence >= options_.min_confidence;
  return estimate;
}

}  // namespace gaitcam
