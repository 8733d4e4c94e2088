/// Point spread function from the power spectrum: the line whose spectrum agrees best with the image's
/// (line_spectra.h).

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_spectra.h"
#include "algorithms/features/log_spectrum.h"
#include "algorithms/features/psf.h"

namespace gaitcam {

struct SpectralOptions {
  using DescribedTag = void;
  int window_px = 256;           ///< Side of the windows, a power of two; a smaller image is padded with zeros.
  double low_frequency = 0.02;   ///< Cycles/px: below, the scene's structure dominates.
  double high_frequency = 0.30;  ///< Above, noise dominates.
  double min_extent_px = 4;      ///< Shortest blur considered: its first zero must lie below high_frequency.
  double max_extent_px = 60;     ///< Longest blur considered.
  double verdict_px = 6;         ///< Shorter blurs are left alone.
  double min_confidence = 0.5;   ///< For the verdict "blurred".
  bool light = false;            ///< Of light (light_response.h) and not of grey values.

  /// @throws BadOption naming field, value and what is permitted.
  void Check() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, SpectralOptions& o) {
  visit("window_px", o.window_px, Between(64, 1024), "side of the windows, a power of two");
  visit("low_frequency", o.low_frequency, Between(0, 0.2), "cycles/px; lower ones are ignored");
  visit("high_frequency", o.high_frequency, Between(0.21, 0.5), "cycles/px; higher ones are ignored");
  visit("min_extent_px", o.min_extent_px, Between(3, 50), "shortest blur considered");
  visit("max_extent_px", o.max_extent_px, Between(8, 250), "longest blur considered");
  visit("verdict_px", o.verdict_px, Between(0, 250), "shorter blurs are left alone");
  visit("min_confidence", o.min_confidence, Between(0, 1), "for the verdict blurred");
  visit("light", o.light, Nested(), "the spectrum of light, and not of grey values");
}

/// Confidence is LineSpectra::Agreement: 0.7 to 0.95 with clear blur, below 0.5 without. Needs 64 x 64 px.
class SpectralPsf : public PsfEstimator {
 public:
  /// @throws BadOption
  explicit SpectralPsf(const SpectralOptions& options = {});
  BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const override;

  /// The estimate from a spectrum that was collected by the caller with windows of options.window_px.
  BlurEstimate Estimate(const PowerSpectrum& spectrum) const;

 private:
  /// @param counts LineSpectra::CountSamples of the spectrum.
  std::vector<LineFit> Candidates(const LogSpectrum& log, const Eigen::VectorXf& counts) const;
  LineFit Refine(const LogSpectrum& log, const Eigen::VectorXf& counts, LineFit fit, double& agreement) const;

  SpectralOptions options_;
  LineSpectra spectra_;
};

}  // namespace gaitcam
