/// The logarithm of an image's power spectrum, normalised for comparison with that of a blur.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// One frequency of half the plane (the other half is redundant, as the image is real).
struct SpectrumSample {
  float fx = 0, fy = 0;  ///< Cycles per px; x to the right, y down.
  float value = 0;       ///< Log power less the mean over all directions at this radius.
  int ring = 0;          ///< Of LogSpectrum::rings.
};

/// Log power between two radial frequencies.
struct LogSpectrum {
  std::vector<SpectrumSample> samples;
  std::vector<float> floors;  ///< Of each ring: power where it is least, in parts of power where it is most.
  float deviation = 0;        ///< Root mean square of the values.
};

/// Power at each frequency, summed over overlapping windows (Welch 1967).
///
/// Each window of the image is high-passed by a Laplacian first, as natural images have so much more power at low
/// frequencies that these would leak over all others; then weighted by a Hann window. Windows count by the square root
/// of their energy's inverse, so that one strong edge does not outvote the rest.
class PowerSpectrum {
 public:
  /// @param window_px side of the window, a power of two.
  explicit PowerSpectrum(int window_px);
  /// Adds the windows that tile `laplacian` (CV_32FC1), at least half overlapping; a shorter side than the window's is
  /// padded with zeros.
  void Add(const cv::Mat& laplacian);

  int window_px() const { return window_px_; }
  bool empty() const { return windows_ == 0; }  ///< Nothing was added that had any contrast.
  /// CV_32FC1, window_px rows of window_px / 2 + 1: column x is fx = x / window_px, row y is fy = y / window_px, or
  /// minus 1 from half the rows on.
  const cv::Mat& power() const { return power_; }

 private:
  int window_px_;
  int windows_ = 0;
  cv::Mat power_;
};

/// Laplacian of an image without what its border would need: CV_32FC1, two rows and columns less.
cv::Mat Laplacian(const cv::Mat& grey);

/// @param low, high radial frequencies, cycles/px.
/// @param rings of equal width between them, in each of which a floor is found.
LogSpectrum MakeLogSpectrum(const PowerSpectrum& spectrum, double low, double high, int rings);

}  // namespace gaitcam
