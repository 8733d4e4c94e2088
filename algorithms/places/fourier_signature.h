/// The Fourier signature that the thesis compares with (3.3, 4.6): the rows are averaged to a single one, and the
/// magnitudes of its first Fourier coefficients are kept; signatures are compared by the sum of absolute differences.
///
/// Magnitudes do not change as a panorama turns, which is what they are good for: two panoramas are compared as they
/// are. A view shows a piece only, and the spectrum of a piece is not that of the whole. Two ways are offered.
/// `kWindows`: a spectrum of each window as wide as a view, every 16 px; the best one counts, as for wavelets.
/// `kWhole`: the single spectrum of the whole panorama, read at the view's frequencies; it has no bearing. Light is
/// taken out in both: rows are freed of mean and gain (standard deviation) before.

#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

constexpr int kFourierCoefficients = 15;  ///< 1 ... 15; coefficient 0 is the brightness.

/// Magnitudes of coefficients 1 ... `coefficients` of the averaged row of CV_8UC1 `image`, freed of mean and gain, over
/// the root of its length.
std::vector<float> FourierSignature(const cv::Mat& image, int coefficients = kFourierCoefficients);

/// Sum of absolute differences. @pre equal lengths.
double FourierDistance(const std::vector<float>& a, const std::vector<float>& b);

enum class FourierScope { kWindows, kWhole };

/// Similarity is 1 / distance.
std::unique_ptr<PlaceIndex> MakeFourierIndex(const PlaceIndexSetup& setup, FourierScope scope);

}  // namespace gaitcam
