#include "algorithms/places/wavelet_search.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "algorithms/core/popcnt_clones.h"

namespace gaitcam {
namespace {

constexpr int kRefineShifts = 6;           // offsets to either side of the best that take part in its refinement, ...
constexpr double kRefineTolerance = 0.05;  // ... if not more than this share of the bits differs in addition
constexpr size_t kMaxWords = kMaxWaveletViewBits / 64;

/// Sums of Eq. 4.4 without the weights.
struct Differences {
  int all = 0, vertical = 0, diagonal = 0;
};

template <bool kDiagonals>
[[gnu::always_inline]] inline Differences Compare(const uint64_t* a, const uint64_t* b, const WaveletProbe& probe) {
  Differences differences;
  for (size_t k = 0; k < probe.words; ++k) {
    const uint64_t differ = (a[k] ^ b[k]) & probe.all[k];
    differences.all += std::popcount(differ);
    differences.vertical += std::popcount(differ & probe.vertical[k]);
    if constexpr (kDiagonals) differences.diagonal += std::popcount(differ & probe.diagonal[k]);
  }
  return differences;
}

struct Best {
  double dissimilarity = 1e300;
  int offset = 0;  // shifts
};

/// One panorama and one view. Diagonal bits are counted only if their weight is not that of the horizontal ones.
template <bool kDiagonals>
struct Comparison {
  const WaveletRing& ring;
  const WaveletProbe& probe;
  const WaveletOptions& options;

  [[gnu::always_inline]] inline void Window(int column, uint64_t* window) const {
    ring.Window(column, probe.words, window);
  }
  /// Eq. 4.4; |d_i - d_r| of two signs that differ is 2.
  [[gnu::always_inline]] inline double Dissimilarity(const uint64_t* window, int shift) const {
    const Differences differ = Compare<kDiagonals>(window, &probe.signatures[size_t(shift) * probe.words], probe);
    double sum = options.weight_h * differ.all + (options.weight_v - options.weight_h) * differ.vertical;
    if constexpr (kDiagonals) sum += (options.weight_d - options.weight_h) * differ.diagonal;
    return 2 * sum;
  }
};

template <bool kDiagonals>
[[gnu::always_inline]] inline Best Slide(const Comparison<kDiagonals>& comparison, WaveletColumns searched) {
  Best best;
  uint64_t window[kMaxWords];
  for (int k = 0; k < searched.count; ++k) {
    const int column = (searched.first + k) % comparison.ring.columns();
    comparison.Window(column, window);
    for (int shift = 0; shift < WaveletOptions::kShifts; ++shift) {
      const double dissimilarity = comparison.Dissimilarity(window, shift);
      if (dissimilarity < best.dissimilarity) best = {dissimilarity, WaveletOptions::kShifts * column - shift};
    }
  }
  return best;
}

/// What the refinement adds to the best offset, in shifts.
template <bool kDiagonals>
[[gnu::always_inline]] inline double Refine(const Comparison<kDiagonals>& comparison, const Best& best,
                                            double tolerance) {
  constexpr int kShifts = WaveletOptions::kShifts;
  const int columns = comparison.ring.columns();
  uint64_t window[kMaxWords];
  double sum = 0, moment = 0;
  for (int step = -kRefineShifts; step <= kRefineShifts; ++step) {
    const int offset = best.offset + step + 2 * kShifts * columns;  // not negative
    const int column = (offset + kShifts - 1) / kShifts;            // rounded up
    comparison.Window(column % columns, window);
    const int shift = kShifts * column - offset;
    const double weight = best.dissimilarity + tolerance - comparison.Dissimilarity(window, shift);
    if (weight <= 0) continue;
    sum += weight;
    moment += weight * step;
  }
  return moment / sum;
}

template <bool kDiagonals>
[[gnu::always_inline]] inline WaveletFit Fit(const Comparison<kDiagonals>& comparison, WaveletColumns searched) {
  const Best best = Slide(comparison, searched);
  const double tolerance = kRefineTolerance * comparison.probe.MaxDissimilarity(comparison.options);
  return {best.dissimilarity, best.offset + Refine(comparison, best, tolerance)};
}

}  // namespace

WaveletProbe::WaveletProbe(const WaveletView& view) {
  const WaveletSignature& first = view.shifts.front();
  bits = size_t(first.bits_per_column()) * size_t(first.columns());
  words = first.words().size();
  WaveletSignature every(first.columns(), first.rows()), v = every, d = every;
  for (int column = 0; column < first.columns(); ++column) {
    for (int row = 0; row < first.rows(); ++row) {
      for (const auto band : {WaveletSignature::kHorizontal, WaveletSignature::kVertical, WaveletSignature::kDiagonal})
        every.Set(band, row, column, true);
      v.Set(WaveletSignature::kVertical, row, column, true);
      d.Set(WaveletSignature::kDiagonal, row, column, true);
    }
  }
  all = every.words();
  vertical = v.words();
  diagonal = d.words();
  for (const WaveletSignature& shift : view.shifts)
    signatures.insert(signatures.end(), shift.words().begin(), shift.words().end());
}

double WaveletProbe::MaxDissimilarity(const WaveletOptions& options) const {
  return 2 * double(bits / 3) * (options.weight_h + options.weight_v + options.weight_d);
}

WaveletRing::WaveletRing(int columns, int bits_per_column, size_t view_bits)
    : columns_(columns),
      bits_per_column_(bits_per_column),
      view_words_(view_bits / 64 + 1),
      words_((size_t(columns) * size_t(bits_per_column) + view_bits) / 64 + 3, 0) {}

void WaveletRing::Load(const uint8_t* packed, size_t bytes) {
  std::fill(words_.begin(), words_.end(), 0);
  std::memcpy(words_.data(), packed, bytes);  // little-endian words, as x86 and ARM have them
  const size_t bits = size_t(columns_) * size_t(bits_per_column_), end = bits / 64;
  const unsigned shift = unsigned(bits % 64);
  for (size_t k = 0; k < view_words_ && end + k + 1 < words_.size(); ++k) {
    const uint64_t first = words_[k];
    words_[end + k] |= first << shift;
    if (shift > 0) words_[end + k + 1] |= first >> (64 - shift);
  }
}

GAITCAM_POPCNT_CLONES WaveletFit FitView(const WaveletRing& ring, WaveletColumns searched, const WaveletProbe& probe,
                                         const WaveletOptions& options) {
  if (options.weight_d != options.weight_h) return Fit(Comparison<true>{ring, probe, options}, searched);
  return Fit(Comparison<false>{ring, probe, options}, searched);
}

}  // namespace gaitcam
