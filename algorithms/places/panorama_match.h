/// Is what the robot sees all around a place that it knows?
///
/// A panorama is no rigid ring: a step aside moves near things that lie across the step, and none that lie along it. So
/// it is taken as views side by side ("sectors"), each of which may slide a little about the turn that all share; their
/// disagreements are averaged. Whole rings agree within some 0.2 m alone, a single view is now better, now worse by its
/// direction, the mean of the sectors falls steadily with the distance (results/studies/khr1hv_loops).

#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

/// A panorama that is looked for: equally spaced sectors, the first of which begins at the left border.
struct PanoramaSectors {
  std::vector<WaveletView> views;
  int panorama_width_px = 0;
};

struct PanoramaMatch {
  double similarity = 0;  ///< SimilarityOf() the sectors' mean disagreement.
  double turn_px = 0;     ///< So many columns further to the right it lies in the known panorama: the sectors' mean.
};

/// As many sectors as fit side by side.
/// @param panorama CV_8UC1, 360 degrees wide, of the encoder's height. @param sector_width_px a view's width.
/// @throws BadInput if the panorama is narrower than a sector, or a sector too narrow for a signature.
PanoramaSectors SectorsOf(const WaveletEncoder& encoder, const cv::Mat& panorama, int sector_width_px);

/// Of all turns the best one, or of those that are asked for.
/// @param slack_deg how far a sector may slide to either side. @param turns so many columns further to the right what
/// is looked for lies, give or take; none: any. @pre place < map.size().
PanoramaMatch MatchPanorama(const WaveletMap& map, size_t place, const PanoramaSectors& sectors, double slack_deg,
                            std::optional<WaveletWindow> turns = {});

}  // namespace gaitcam
