/// Where along a panorama's signature does a view's fit best? Eq. 4.4 at every offset, 64 bits at a time.

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

/// A view as the search reads it: the words of its signatures, and masks that tell the bands apart.
struct WaveletProbe {
  explicit WaveletProbe(const WaveletView& view);
  /// Diss of Eq. 4.4 if every bit differed.
  double MaxDissimilarity(const WaveletOptions& options) const;

  size_t bits = 0, words = 0;                     ///< Of one signature.
  std::vector<uint64_t> signatures;               ///< `words` of each shift, one shift after the other.
  std::vector<uint64_t> all, vertical, diagonal;  ///< `words` each: the bits that are used, those of V, those of D.
};

/// A panorama's bits, followed by as many of its first ones again as a view that begins in its last column needs.
class WaveletRing {
 public:
  WaveletRing(int columns, int bits_per_column, size_t view_bits);

  /// Takes the place of what was loaded before. @param packed the bytes of WaveletSignature::words().
  void Load(const uint8_t* packed, size_t bytes);
  int columns() const { return columns_; }
  /// `count` words that begin with `column`. @pre column < columns(); 64 count exceeds a view's bits by less than 64.
  void Window(int column, size_t count, uint64_t* out) const {
    const size_t begin = size_t(column) * size_t(bits_per_column_);
    const uint64_t* from = &words_[begin / 64];
    const unsigned shift = unsigned(begin % 64);
    for (size_t k = 0; k < count; ++k) out[k] = (from[k] >> shift) | ((from[k + 1] << 1) << (63 - shift));
  }

 private:
  int columns_, bits_per_column_;
  size_t view_words_;
  std::vector<uint64_t> words_;
};

/// Columns in which a view may begin: `count` of them from `first` on, across the seam.
struct WaveletColumns {
  int first = 0, count = 0;
};

struct WaveletFit {
  double dissimilarity = 1e300;  ///< Diss of Eq. 4.4, the least of all offsets.
  double offset = 0;  ///< Of the view's left edge against the panorama's, in shifts of WaveletOptions::shift_px().
};

/// The best of all offsets, in steps of one shift, refined: a bit more or less decides between neighbouring offsets, so
/// the mean of those about the best is taken, weighted by how much better than a tolerance they fit.
WaveletFit FitView(const WaveletRing& ring, WaveletColumns searched, const WaveletProbe& probe,
                   const WaveletOptions& options);

/// Bits that a view may have. Checked where views come in.
constexpr size_t kMaxWaveletViewBits = 4096;

}  // namespace gaitcam
