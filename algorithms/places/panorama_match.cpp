#include "algorithms/places/panorama_match.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

struct SectorFit {
  double disagreement = std::numeric_limits<double>::infinity();  ///< Mean of the sectors.
  double turn_px = 0;                                             ///< Likewise.
};

SectorFit FitAbout(const WaveletMap& map, const PanoramaSectors& sectors, size_t place, const WaveletWindow& turn) {
  const double width_px = sectors.panorama_width_px, count = double(sectors.views.size());
  SectorFit fit{0, turn.left_px};
  for (size_t k = 0; k < sectors.views.size(); ++k) {
    const double left_px = double(k) * width_px / count + turn.left_px;
    const WaveletMatch match = map.Query(sectors.views[k], place, WaveletWindow{left_px, turn.tolerance_px});
    fit.disagreement += match.disagreement / count;
    fit.turn_px += std::remainder(match.left_px - left_px, width_px) / count;
  }
  return fit;
}

}  // namespace

PanoramaSectors SectorsOf(const WaveletEncoder& encoder, const cv::Mat& panorama, int sector_width_px) {
  if (panorama.cols < sector_width_px) {
    throw BadInput("a panorama of " + std::to_string(panorama.cols) + " px is narrower than its sectors of " +
                   std::to_string(sector_width_px) + " px");
  }
  cv::Mat unrolled;
  cv::hconcat(panorama, panorama.colRange(0, sector_width_px), unrolled);
  PanoramaSectors sectors;
  sectors.panorama_width_px = panorama.cols;
  const int count = panorama.cols / sector_width_px;
  for (int k = 0; k < count; ++k) {
    const int left = k * panorama.cols / count;
    sectors.views.push_back(encoder.OfView(unrolled.colRange(left, left + sector_width_px)));
  }
  return sectors;
}

PanoramaMatch MatchPanorama(const WaveletMap& map, size_t place, const PanoramaSectors& sectors, double slack_deg,
                            std::optional<WaveletWindow> turns) {
  GAITCAM_ASSERT(!sectors.views.empty() && slack_deg >= 0);
  const double width_px = sectors.panorama_width_px, slack_px = slack_deg / 360 * width_px;
  const double step_px = std::max(1.0, 0.5 * slack_px);  // so that the sectors' windows overlap
  const WaveletWindow searched = turns.value_or(WaveletWindow{0, 0.5 * width_px});
  const int reach = int(searched.tolerance_px / step_px);
  SectorFit best;
  for (int k = -reach; k <= reach; ++k) {
    const SectorFit fit = FitAbout(map, sectors, place, {searched.left_px + k * step_px, slack_px});
    if (fit.disagreement < best.disagreement) best = fit;
  }
  const WaveletSignature& first = sectors.views.front().shifts.front();
  const int bits = int(sectors.views.size()) * first.columns() * first.bits_per_column();
  return {SimilarityOf(best.disagreement, bits), best.turn_px};
}

}  // namespace gaitcam
