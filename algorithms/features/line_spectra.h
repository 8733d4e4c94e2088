/// Power spectra of line blurs, and their correlation with the logarithm of an image's.
///
/// The spectrum of a line is sinc^2 of its length times the frequency along it, with zeros on equidistant parallel
/// lines. The logarithm turns the product of image and blur into a sum; the blur's part is then known up to direction
/// and extent. As it depends on the frequency along the direction alone, the samples are first summed to a profile over
/// that frequency, and with this every extent is compared.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "algorithms/features/log_spectrum.h"

namespace gaitcam {

/// A line that was compared with a spectrum.
struct LineFit {
  double extent_px = 0, direction_rad = 0;
  double correlation = -1;  ///< Pearson's, of ripple and log power over all samples.
};

class LineSpectra {
 public:
  static constexpr int kRings = 6;            ///< Of radial frequency, each with a floor of its own.
  static constexpr int kBins = 96;            ///< Of frequency along the direction, in each ring.
  static constexpr double kExtentStep = 0.5;  ///< Between the lines that are compared, px.

  /// @param window_px side of the Hann window of the spectra to come: it smears them.
  /// @param min_extent_px, max_extent_px of the lines; @param high_frequency of the spectra, cycles/px.
  LineSpectra(int window_px, double min_extent_px, double max_extent_px, double high_frequency);

  /// Log power of lines of a range of extents in one image, where noise fills their zeros and hides their side lobes.
  /// Of that, the ripple alone, which is less than its mean over one period: images have slopes of their own in their
  /// spectra, but hardly ever a period.
  struct Templates {
    int first = 0;           ///< Row of the first extent in the table of all.
    Eigen::MatrixXf values;  ///< kRings * kBins rows, one column for each extent.
    Eigen::VectorXf norms;   ///< Euclidean norm of each over all samples.
  };
  /// How many samples a spectrum has in each bin of each ring, which hardly depends on the direction of the lines.
  Eigen::VectorXf CountSamples(const LogSpectrum& log) const;
  /// @param counts CountSamples of the spectrum.
  /// @param floors of each ring: power in the zeros, in parts of that between them.
  Templates MakeTemplates(const Eigen::VectorXf& counts, const std::vector<float>& floors, double low_px,
                          double high_px) const;

  /// Correlation of each of the templates with a spectrum, if the lines had this direction.
  Eigen::VectorXf Correlate(const LogSpectrum& log, const Templates& templates, double direction_rad) const;
  /// The same for two directions, in less than twice the time.
  std::array<Eigen::VectorXf, 2> Correlate(const LogSpectrum& log, const Templates& templates,
                                           const std::array<double, 2>& directions_rad) const;
  /// The best of a range of correlations; between the extents of the table by a parabola.
  LineFit Best(const Templates& templates, const Eigen::VectorXf& correlations, int begin, int end) const;
  /// Number of the first template that is at least this long.
  int Index(const Templates& templates, double extent_px) const;

  /// How far the zeros are filled in each ring if this is the blur; where that cannot be seen, `otherwise`.
  std::vector<float> MeasureFloors(const LogSpectrum& log, const LineFit& fit,
                                   const std::vector<float>& otherwise) const;
  /// Correlation of a line's ripple, beyond the lobe in the middle, with that of the profile over the frequency along
  /// it. Unlike the correlation with all samples it is near 1 for every blur that is seen clearly. Scaled down to 0 if
  /// the ripple has peaks rather than zeros, as that of a periodic image has.
  double Agreement(const LogSpectrum& log, const Templates& templates, const LineFit& fit) const;

 private:
  /// Sums of the samples' values in each bin of each ring, by the frequency along each of N directions.
  template <size_t N>
  std::array<Eigen::VectorXf, N> MakeProfiles(const LogSpectrum& log,
                                              const std::array<double, N>& directions_rad) const;
  template <size_t N, class Add>
  void ForEachBin(const LogSpectrum& log, const std::array<double, N>& directions_rad, Add add) const;
  Eigen::VectorXf CountSamples(const LogSpectrum& log, double direction_rad) const;

  double min_extent_px_, high_frequency_;
  int extents_;
  Eigen::MatrixXf power_;  ///< kBins rows, a column for each extent.
};

}  // namespace gaitcam
