/// The signatures of known panoramas, and how well a view fits each of them (thesis 4.4.4).

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

/// How well a view fits a panorama, where it fits best.
struct WaveletMatch {
  double disagreement = 1;  ///< Share of the bits that differ, weighted: Diss of Eq. 4.4 over its greatest value.
  double similarity = 0;    ///< SimilarityOf() it.
  double left_px = 0;       ///< Column of the panorama under the view's first one; may be negative.
};

/// Eq. 4.3 scaled so that it does not depend on the views' width: 1 / (2 disagreement), which is 1 where half of the
/// bits differ, as those of unrelated images do, and 2 where a quarter does. Finite where none does: half of a bit is
/// taken to differ.
double SimilarityOf(double disagreement, int bits);

/// Where in a panorama a view may lie: its first column is within `tolerance_px` of column `left_px`.
struct WaveletWindow {
  double left_px = 0;
  double tolerance_px = 0;
};

/// Signatures of panoramas, of one size, packed to whole bytes.
class WaveletMap {
 public:
  explicit WaveletMap(const WaveletOptions& options = {}) : options_(options) {}

  /// @throws BadInput if it is not of the size of those before.
  void Add(const WaveletSignature& panorama);
  size_t size() const { return places_; }
  size_t bytes_per_place() const { return bytes_; }
  /// The view slides over each panorama, across its seam; one match for each, in the order of Add().
  /// @throws BadInput if the map is empty or its panoramas are narrower than the view.
  std::vector<WaveletMatch> Query(const WaveletView& view) const;
  /// Of one panorama alone, and of the part of it where the view may lie. @pre place < size().
  WaveletMatch Query(const WaveletView& view, size_t place, std::optional<WaveletWindow> window = {}) const;

 private:
  void CheckView(const WaveletView& view) const;

  WaveletOptions options_;
  size_t places_ = 0, bytes_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<uint8_t> packed_;
};

}  // namespace gaitcam
