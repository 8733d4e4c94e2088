/// Point spread function from the power spectrum: that of a line is sinc^2 of its length times the frequency along it,
/// with zeros on equidistant parallel lines.
///
/// The logarithm turns the product of image and blur into a sum, in which the blur's part is known up to direction and
/// extent: the pair that correlates best with the image's log spectrum is the estimate. As sinc^2 depends on the
/// frequency along the direction alone, a direction's spectrum is first summed to a profile over that frequency, with
/// which every extent is compared.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/log_spectrum.h"
#include "algorithms/features/psf.h"

namespace gaitcam {

struct SpectralOptions {
  using DescribedTag = void;
  int window_px = 256;           ///< Side of the windows, a power of two.
  double low_frequency = 0.02;   ///< Cycles/px: below, the image's own structure rules.
  double high_frequency = 0.30;  ///< Above, noise does.
  double min_extent_px = 3;      ///< Shortest blur looked for.
  double max_extent_px = 60;     ///< Longest blur looked for.
  double verdict_px = 4;         ///< Shorter blurs are left alone.
  double min_confidence = 0.5;   ///< For the verdict "blurred".
};

template <class Visitor>
void VisitFields(Visitor& visit, SpectralOptions& o) {
  visit("window_px", o.window_px, Between(32, 1024), "side of the windows, a power of two");
  visit("low_frequency", o.low_frequency, Between(0, 0.5), "cycles/px; what lies below does not count");
  visit("high_frequency", o.high_frequency, Between(0, 0.5), "cycles/px; what lies above does not count");
  visit("min_extent_px", o.min_extent_px, Between(1, 50), "shortest blur looked for");
  visit("max_extent_px", o.max_extent_px, Between(4, 250), "longest blur looked for");
  visit("verdict_px", o.verdict_px, Between(0, 250), "shorter blurs are left alone");
  visit("min_confidence", o.min_confidence, Between(0, 1), "for the verdict blurred");
}

/// What log sinc^2 is in each bin of frequency for each of many extents, and how to compare profiles with it.
class LineSpectra {
 public:
  LineSpectra(double min_extent_px, double max_extent_px, double high_frequency);

  /// Sums of samples over bins of frequency along one direction.
  struct Profile {
    std::vector<float> sum, count;
  };
  Profile Project(const std::vector<SpectrumSample>& samples, double direction_rad) const;

  struct Fit {
    double extent_px = 0, direction_rad = 0;
    double correlation = -1;  ///< Pearson's.
  };
  /// Best extent for a profile; between the extents of the table by a parabola.
  Fit Best(const Profile& profile) const;

 private:
  double min_extent_px_, bins_per_frequency_;
  int bins_, extents_;
  std::vector<float> log_power_;  ///< extents_ rows of bins_.
};

/// Confidence is the correlation. Needs 64 x 64 px.
class SpectralPsf : public PsfEstimator {
 public:
  /// @throws BadOption
  explicit SpectralPsf(const SpectralOptions& options = {});
  BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const override;

 private:
  SpectralOptions options_;
  LineSpectra spectra_;
};

}  // namespace gaitcam
