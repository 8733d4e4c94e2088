#include "algorithms/features/psf_spectral.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/features/light_response.h"

namespace gaitcam {
namespace {

constexpr int kMinSide = 64;
constexpr int kSpectrumDirections = 60;  ///< Of the first search: every 3 degrees; even.
/// The ripple of a short line is broad, and a structured image resembles it more easily: long lines are looked for
/// apart from short ones, as many of these as of those.
constexpr double kLongFrom = 12;
constexpr size_t kCandidatesEach = 3;
constexpr double kReach = 2.5;  ///< px, how far a refined extent may lie from the first one.
constexpr float kSpectrumFloorShare = 0.3f;

/// Directions whose fit is better than that of their neighbours, best first, at most `most`.
void AddPeaks(const std::vector<LineFit>& fits, size_t most, std::vector<LineFit>& peaks) {
  std::vector<LineFit> found;
  const size_t n = fits.size();
  for (size_t i = 0; i < n; ++i) {
    const double here = fits[i].correlation;
    if (here >= fits[(i + n - 1) % n].correlation && here > fits[(i + 1) % n].correlation) found.push_back(fits[i]);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const LineFit& a, const LineFit& b) { return a.correlation > b.correlation; });
  found.resize(std::min(found.size(), most));
  peaks.insert(peaks.end(), found.begin(), found.end());
}

/// As Laplacian has it of grey values; white is 255.
cv::Mat LaplacianOfLight(const cv::Mat& grey) {
  cv::Mat edges;
  cv::Laplacian(LightOfGrey(grey), edges, CV_32F, 1, -255);
  return edges(cv::Rect(1, 1, grey.cols - 2, grey.rows - 2)).clone();
}

}  // namespace

void SpectralOptions::Check() const {
  CheckFields(*this);
  if ((window_px & (window_px - 1)) != 0) {
    throw BadOption("window_px: " + std::to_string(window_px) + " is not a power of two");
  }
  if (!(max_extent_px > min_extent_px)) throw BadOption("max_extent_px must be greater than min_extent_px");
}

SpectralPsf::SpectralPsf(const SpectralOptions& options)
    : options_((options.Check(), options)),
      spectra_(options.window_px, options.min_extent_px, options.max_extent_px, options.high_frequency) {}

std::vector<LineFit> SpectralPsf::Candidates(const LogSpectrum& log, const Eigen::VectorXf& counts) const {
  std::vector<float> floors = log.floors;
  for (float& floor : floors) floor *= kSpectrumFloorShare;
  const LineSpectra::Templates templates =
      spectra_.MakeTemplates(counts, floors, options_.min_extent_px, options_.max_extent_px);
  const int all = int(templates.norms.size()), split = spectra_.Index(templates, kLongFrom);
  std::vector<LineFit> short_fits, long_fits;
  for (int i = 0; i < kSpectrumDirections; i += 2) {
    const std::array<double, 2> directions = {M_PI * i / kSpectrumDirections, M_PI * (i + 1) / kSpectrumDirections};
    const auto correlations = spectra_.Correlate(log, templates, directions);
    for (size_t n = 0; n < directions.size(); ++n) {
      for (auto [fits, begin, end] : {std::tuple(&short_fits, 0, split), std::tuple(&long_fits, split, all)}) {
        if (begin >= end) continue;
        fits->push_back(spectra_.Best(templates, correlations[n], begin, end));
        fits->back().direction_rad = directions[n];
      }
    }
  }
  std::vector<LineFit> candidates;
  AddPeaks(short_fits, kCandidatesEach, candidates);
  AddPeaks(long_fits, kCandidatesEach, candidates);
  return candidates;
}

LineFit SpectralPsf::Refine(const LogSpectrum& log, const Eigen::VectorXf& counts, LineFit fit,
                            double& agreement) const {
  const LineSpectra::Templates templates = spectra_.MakeTemplates(counts, spectra_.MeasureFloors(log, fit, log.floors),
                                                                  fit.extent_px - kReach, fit.extent_px + kReach);
  const auto best = [&](const Eigen::VectorXf& correlations, double direction) {
    LineFit found = spectra_.Best(templates, correlations, 0, int(correlations.size()));
    found.direction_rad = direction;
    return found;
  };
  fit = best(spectra_.Correlate(log, templates, fit.direction_rad), fit.direction_rad);
  for (double step = 1.5 * kRadPerDeg; step > 0.1 * kRadPerDeg; step /= 2) {
    const std::array<double, 2> directions = {fit.direction_rad - step, fit.direction_rad + step};
    const auto correlations = spectra_.Correlate(log, templates, directions);
    for (size_t n = 0; n < directions.size(); ++n) {
      const LineFit beside = best(correlations[n], directions[n]);
      if (beside.correlation > fit.correlation) fit = beside;
    }
  }
  agreement = spectra_.Agreement(log, templates, fit);
  return fit;
}

BlurEstimate SpectralPsf::Estimate(const PowerSpectrum& spectrum) const {
  GAITCAM_ASSERT(spectrum.window_px() == options_.window_px);
  if (spectrum.empty()) return {};
  const LogSpectrum log =
      MakeLogSpectrum(spectrum, options_.low_frequency, options_.high_frequency, LineSpectra::kRings);
  LineFit best;
  double best_agreement = 0;
  const Eigen::VectorXf counts = spectra_.CountSamples(log);
  for (const LineFit& candidate : Candidates(log, counts)) {
    double agreement = 0;
    const LineFit fit = Refine(log, counts, candidate, agreement);
    if (agreement <= best_agreement) continue;
    best = fit;
    best_agreement = agreement;
  }
  BlurEstimate estimate;
  estimate.blur = {best.extent_px, std::fmod(best.direction_rad + M_PI, M_PI)};
  estimate.confidence = std::min(best_agreement, 1.0);
  estimate.blurred = estimate.blur.extent_px >= options_.verdict_px && estimate.confidence >= options_.min_confidence;
  return estimate;
}

BlurEstimate SpectralPsf::Estimate(const cv::Mat& grey, const cv::Rect& region) const {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  const cv::Rect seen = region & cv::Rect({0, 0}, grey.size());
  if (seen.width < kMinSide || seen.height < kMinSide) return {};
  PowerSpectrum spectrum(options_.window_px);
  spectrum.Add(options_.light ? LaplacianOfLight(grey(seen)) : Laplacian(grey(seen)));
  return Estimate(spectrum);
}

}  // namespace gaitcam
