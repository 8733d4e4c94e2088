/// The wavelet signature of an image: signs of its coarse Haar wavelet coefficients, 170 bytes for a panorama
/// (thesis 4.4).
///
/// The image is smoothed by a Gaussian and decomposed by the 2-D Haar transform down to `level`; the
/// detail coefficients of that level, one horizontal, vertical and diagonal one for each square of 2^level pixels, are
/// kept as one bit each: 1 for d >= 0 (4.4.3). A panorama of 720 x 160 px has 45 x 10 x 3 = 1350 bits.
///
/// The thesis's Gaussian has sigma = 2^level, a whole square. Half a square is the default here: neighbouring bits are
/// then less correlated, and of 200 views in a soccer field with 117 reference panoramas, 97 % instead of 86 % find the
/// nearest one or a neighbour of it.
///
/// Only level `level` of the transform is needed, so the quadrants of its squares are summed directly; the Gaussian is
/// applied to pixels that were averaged beforehand, by 2^level / 8 across and 2^level / 4 down, with its variance
/// reduced by theirs. That changes the sign of fewer than one coefficient in a hundred, those close to 0. A coefficient
/// within kNoDetail of 0 counts as 0: rounding must not decide about a blank wall.

#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

struct WaveletOptions {
  using DescribedTag = void;
  int level = 4;
  double prefilter = 0.5;  ///< Sigma of the Gaussian in squares of 2^level px; the thesis has 1.
  double weight_h = 0.25;  ///< w_h of Eq. 4.4.
  double weight_v = 0.5;   ///< w_v; rooms have more vertical edges.
  double weight_d = 0.25;  ///< w_d.

  int square_px() const { return 1 << level; }
  int shift_px() const { return square_px() / kShifts; }
  static constexpr int kShifts = 8;  ///< Signatures of a view, each shift_px() further to the right (4.4.4).
};

template <class Visitor>
void VisitFields(Visitor& visit, WaveletOptions& o) {
  visit("level", o.level, Between(3, 6), "of the Haar transform");
  visit("prefilter", o.prefilter, Between(0.2, 2.0), "sigma of the Gaussian before, in squares of 2^level px");
  visit("weight_h", o.weight_h, Between(0.0, 1.0), "of horizontal edges");
  visit("weight_v", o.weight_v, Between(0.0, 1.0), "of vertical edges");
  visit("weight_d", o.weight_d, Between(0.0, 1.0), "of diagonal edges");
}

/// The bits, column by column: H of all rows, then V, then D, then the next column. A range of columns is a range of
/// bits.
class WaveletSignature {
 public:
  enum Band { kHorizontal, kVertical, kDiagonal };

  WaveletSignature() = default;
  WaveletSignature(int columns, int rows);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool empty() const { return columns_ == 0; }
  /// Packed: 169 for 720 x 160 px.
  size_t bytes() const { return (size_t(bits_per_column()) * size_t(columns_) + 7) / 8; }
  int bits_per_column() const { return 3 * rows_; }

  bool Bit(Band band, int row, int column) const;
  void Set(Band band, int row, int column, bool value);
  /// Bit k is bit k % 64 of word k / 64; the last word is filled up with zeros.
  const std::vector<uint64_t>& words() const { return words_; }
  bool operator==(const WaveletSignature& other) const = default;

 private:
  size_t Index(Band band, int row, int column) const;

  int columns_ = 0, rows_ = 0;
  std::vector<uint64_t> words_;
};

/// The signatures of a view without its first 0, 2, 4, ... 14 columns of pixels (level 4), so that it is located in a
/// panorama to a fraction of a square. All have the same number of columns.
struct WaveletView {
  std::vector<WaveletSignature> shifts;
  int width_px = 0;
};

/// Makes signatures of images of one height.
class WaveletEncoder {
 public:
  /// @throws BadOption; BadInput if the height gives no square.
  WaveletEncoder(int height_px, const WaveletOptions& options = {});

  /// @param panorama CV_8UC1 of the encoder's height, 360 degrees wide: its right border continues at its left one. A
  /// width that is no multiple of a square is scaled to the next lower one. @throws BadInput.
  WaveletSignature OfPanorama(const cv::Mat& panorama) const;
  /// @param view CV_8UC1 of the encoder's height and the panoramas' scale. Its left and right border pixels are
  /// repeated outwards. @throws BadInput if it is too narrow.
  WaveletView OfView(const cv::Mat& view) const;
  const WaveletOptions& options() const { return options_; }

 private:
  struct Smoothed;
  void CheckImage(const cv::Mat& image, const char* what) const;
  Smoothed Smooth(const cv::Mat& image, bool circular) const;
  WaveletSignature Signs(const Smoothed& smoothed, int first, int columns) const;

  WaveletOptions options_;
  int height_px_ = 0, rows_ = 0;
  std::vector<float> across_;  ///< Gaussian filter times mean of half a square, over pixels averaged by shift_px().
  cv::Mat down_;               ///< Likewise, as a matrix: half squares from pixels averaged by square / 4; CV_32F.
};

}  // namespace gaitcam
