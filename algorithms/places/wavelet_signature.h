/// A place in 170 bytes: signs of an image's coarse Haar wavelet coefficients (thesis, chapter 4.4).
///
/// The image is smoothed by a Gaussian and decomposed by the 2-D Haar transform down to `level`; the
/// detail coefficients of that level, one horizontal, vertical and diagonal one for each square of 2^level pixels, are
/// kept as one bit each: 1 for d >= 0 (4.4.3). A panorama of 720 x 160 px has 45 x 10 x 3 = 1350 bits.
///
/// The thesis's Gaussian has sigma = 2^level, a whole square. Half a square is the default here: neighbouring bits then
/// say less of the same, and of 200 views in a soccer field with 117 references, 97 % instead of 86 % find the nearest
/// one or a neighbour of it.
///
/// Level `level` of the transform alone is wanted, so its squares' quadrants are summed directly; the filter is made
/// for pixels that were averaged beforehand, by 2^level / 8 across and 2^level / 4 down, and is narrower by their
/// variance. That changes the sign of fewer than one coefficient in a hundred, those next to 0. The sign of a
/// coefficient within kNoDetail of 0 is that of 0: rounding must not decide about a blank wall.

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
  double weight_h = 0.25;  ///< Of horizontal edges in Eq. 4.4, ...
  double weight_v = 0.5;   ///< ... vertical ones, of which rooms have more, ...
  double weight_d = 0.25;  ///< ... and diagonal ones.

  int square_px() const { return 1 << level; }
  int shift_px() const { return square_px() / kShifts; }
  static constexpr int kShifts = 8;  ///< A view's signature is taken so often, each shift_px() further to the right.
};

template <class Visitor>
void VisitFields(Visitor& visit, WaveletOptions& o) {
  visit("level", o.level, Between(3, 6), "of the Haar transform");
  visit("prefilter", o.prefilter, Between(0.2, 2.0), "sigma of the Gaussian before, in squares of 2^level px");
  visit("weight_h", o.weight_h, Between(0.0, 1.0), "of horizontal edges");
  visit("weight_v", o.weight_v, Between(0.0, 1.0), "of vertical edges");
  visit("weight_d", o.weight_d, Between(0.0, 1.0), "of diagonal edges");
}

/// The bits, column by column: H of all rows, then V, then D, then the next column. So columns that follow each other
/// are bits that follow each other.
class WaveletSignature {
 public:
  enum Band { kHorizontal, kVertical, kDiagonal };

  WaveletSignature() = default;
  WaveletSignature(int columns, int rows);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool empty() const { return columns_ == 0; }
  /// What it takes to store: 169 for 720 x 160 px.
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

/// A view as it is compared: its signature, and those of what is left of it without its first 2, 4, ... 14 pixels
/// (level 4), so that it fits panoramas to a fraction of a square. All have the same number of columns.
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
  /// width that is no multiple of a square is scaled to one. @throws BadInput.
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
  std::vector<float> across_;  ///< Gaussian and half a square's mean, over pixels averaged by shift_px().
  cv::Mat down_;               ///< Likewise, as a matrix: half squares from pixels averaged by square / 4; CV_32F.
};

/// How well a view fits a panorama, where it fits best.
struct WaveletMatch {
  double disagreement = 1;  ///< Share of the bits that differ, weighted: Diss of Eq. 4.4 over its greatest value.
  double similarity = 0;    ///< Eq. 4.3 in units of a coin toss's: 1 / (2 disagreement), see SimilarityOf().
  double left_px = 0;       ///< Column of the panorama under the view's first one; may be negative.
};

/// Eq. 4.3, independent of the views' width: 1 where half of the bits differ, as those of unrelated pictures do, 2
/// where a quarter does. Finite where none does: half of a bit is taken to differ.
double SimilarityOf(double disagreement, int bits);

/// Where in a panorama a view may lie.
struct WaveletWindow {
  double left_px = 0;       ///< Column under the view's first one, ...
  double tolerance_px = 0;  ///< ... give or take.
};

/// Signatures of panoramas, of one size, packed to whole bytes.
class WaveletMap {
 public:
  explicit WaveletMap(const WaveletOptions& options = {}) : options_(options) {}

  /// @throws BadInput if it is not of the size of those before.
  void Add(const WaveletSignature& panorama);
  size_t size() const { return places_; }
  size_t bytes_per_place() const { return bytes_; }
  /// The view slides over each panorama, round its seam (4.4.4); one match for each, in the order of Add().
  /// @throws BadInput if the map is empty or its panoramas are narrower than the view.
  std::vector<WaveletMatch> Query(const WaveletView& view) const;
  /// Of one place alone, and, where that is known, in a part of it alone. @pre place < size().
  WaveletMatch Query(const WaveletView& view, size_t place, std::optional<WaveletWindow> window = {}) const;

 private:
  void CheckView(const WaveletView& view) const;

  WaveletOptions options_;
  size_t places_ = 0, bytes_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<uint8_t> packed_;
};

}  // namespace gaitcam
