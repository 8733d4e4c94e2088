/// Does a panorama show a known place?
///
/// A translation of the camera shifts near objects abeam of it and none ahead of it, so two panoramas of one place do
/// not match rigidly. The panorama is therefore divided into views side by side ("sectors"), each of which may slide a
/// little about the rotation that all share; their disagreements are averaged. Rigid panoramas match within some 0.2 m
/// alone, and the similarity of a single view depends on its direction; the mean over the sectors falls steadily with
/// the distance (results/studies/khr1hv_loops).

#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/places/wavelet_map.h"
#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

/// The query panorama: equally spaced sectors, the first of which begins at the left border.
struct PanoramaSectors {
  std::vector<WaveletView> views;
  int panorama_width_px = 0;
};

struct PanoramaMatch {
  double similarity = 0;  ///< SimilarityOf() the sectors' mean disagreement.
  double turn_px = 0;     ///< Columns by which it lies further right in the known panorama: the sectors' mean.
};

/// As many sectors as fit side by side.
/// @param panorama CV_8UC1, 360 degrees wide, of the encoder's height. @param sector_width_px a view's width.
/// @throws BadInput if the panorama is narrower than a sector, or a sector too narrow for a signature.
PanoramaSectors SectorsOf(const WaveletEncoder& encoder, const cv::Mat& panorama, int sector_width_px);

/// The best match over all rotations, or over those permitted.
/// @param slack_deg how far a sector may slide to either side. @param turns the permitted values of turn_px; none: any.
/// @pre place < map.size().
PanoramaMatch MatchPanorama(const WaveletMap& map, size_t place, const PanoramaSectors& sectors, double slack_deg,
                            std::optional<WaveletWindow> turns = {});

}  // namespace gaitcam
