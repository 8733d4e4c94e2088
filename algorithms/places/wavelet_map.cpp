#include "algorithms/places/wavelet_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/places/wavelet_search.h"

namespace gaitcam {
namespace {

WaveletMatch MatchOf(const WaveletFit& fit, const WaveletProbe& probe, const WaveletOptions& options) {
  WaveletMatch match;
  match.disagreement = fit.dissimilarity / probe.MaxDissimilarity(options);
  match.similarity = SimilarityOf(match.disagreement, int(probe.bits));
  match.left_px = options.shift_px() * fit.offset;
  return match;
}

}  // namespace

double SimilarityOf(double disagreement, int bits) { return 1 / (2 * std::max(disagreement, 0.5 / bits)); }

void WaveletMap::Add(const WaveletSignature& panorama) {
  if (places_ == 0) {
    columns_ = panorama.columns();
    rows_ = panorama.rows();
    bytes_ = panorama.bytes();
  }
  if (panorama.empty() || panorama.columns() != columns_ || panorama.rows() != rows_) {
    throw BadInput("wavelet map: a panorama of " + std::to_string(panorama.columns()) + " x " +
                   std::to_string(panorama.rows()) + " squares among those of " + std::to_string(columns_) + " x " +
                   std::to_string(rows_));
  }
  packed_.resize((places_ + 1) * bytes_);
  std::memcpy(&packed_[places_ * bytes_], panorama.words().data(), bytes_);
  ++places_;
}

void WaveletMap::CheckView(const WaveletView& view) const {
  if (places_ == 0) throw BadInput("wavelet map: it is empty, there is nothing to compare a view with");
  GAITCAM_ASSERT(view.shifts.size() == WaveletOptions::kShifts);
  const WaveletSignature& first = view.shifts.front();
  if (first.rows() != rows_) {
    throw BadInput("wavelet map: a view of " + std::to_string(first.rows()) + " squares high, panoramas of " +
                   std::to_string(rows_));
  }
  if (first.columns() > columns_) {
    throw BadInput("wavelet map: the panoramas, " + std::to_string(columns_) +
                   " squares wide, are narrower than the view, " + std::to_string(first.columns()));
  }
  GAITCAM_ASSERT(size_t(first.bits_per_column()) * size_t(first.columns()) <= kMaxWaveletViewBits);
}

std::vector<WaveletMatch> WaveletMap::Query(const WaveletView& view) const {
  CheckView(view);
  const WaveletProbe probe(view);
  WaveletRing ring(columns_, 3 * rows_, probe.bits);
  std::vector<WaveletMatch> matches;
  matches.reserve(places_);
  for (size_t place = 0; place < places_; ++place) {
    ring.Load(&packed_[place * bytes_], bytes_);
    matches.push_back(MatchOf(FitView(ring, {0, columns_}, probe, options_), probe, options_));
  }
  return matches;
}

WaveletMatch WaveletMap::Query(const WaveletView& view, size_t place, std::optional<WaveletWindow> window) const {
  CheckView(view);
  GAITCAM_ASSERT(place < places_);
  WaveletColumns searched{0, columns_};
  if (window) {
    const double square = options_.square_px();
    const int first = int(std::floor((window->left_px - window->tolerance_px) / square));
    const int last = int(std::ceil((window->left_px + window->tolerance_px) / square));
    if (last - first + 1 < columns_) searched = {((first % columns_) + columns_) % columns_, last - first + 1};
  }
  const WaveletProbe probe(view);
  WaveletRing ring(columns_, 3 * rows_, probe.bits);
  ring.Load(&packed_[place * bytes_], bytes_);
  return MatchOf(FitView(ring, searched, probe, options_), probe, options_);
}

}  // namespace gaitcam
