/// The Fourier signature, which the thesis compares the wavelet signature with (3.3, 4.6): the rows are averaged to a
/// single one, and the magnitudes of its first Fourier coefficients are kept; signatures are compared by the sum of
/// absolute differences.
///
/// Magnitudes are invariant to the rotation of a panorama. A view shows a section only, the spectrum of which is not
/// that of the whole. There are two variants. `kWindows`: a spectrum of each window as wide as a view, every 16 px; the
/// best one counts, as for wavelets. `kWhole`: the single spectrum of the whole panorama, sampled at the view's
/// frequencies; it has no bearing. Both are normalised against illumination: the averaged row has mean 0 and standard
/// deviation 1.

#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

constexpr int kFourierCoefficients = 15;  ///< 1 ... 15; coefficient 0 is the brightness.

/// Magnitudes of coefficients 1 ... `coefficients` of the averaged and normalised row of CV_8UC1 `image`, over the
/// square root of its length.
std::vector<float> FourierSignature(const cv::Mat& image, int coefficients = kFourierCoefficients);

/// Sum of absolute differences. @pre equal lengths.
double FourierDistance(const std::vector<float>& a, const std::vector<float>& b);

enum class FourierScope { kWindows, kWhole };

/// Similarity is 1 / distance.
std::unique_ptr<PlaceIndex> MakeFourierIndex(const PlaceIndexSetup& setup, FourierScope scope);

}  // namespace gaitcam
