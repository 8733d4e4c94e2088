/// A mapped floor and the true one, cell by cell. An inner part of floor_score.cpp.

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "algorithms/core/floor_picture.h"
#include "results/scoring/floor_alignment.h"

namespace gaitcam::internal {

/// The map without cells that were seen less than `min_sightings` times, cropped to the rest; empty if none is left.
FloorPicture WellSeen(const FloorPicture& map, int min_sightings);

/// The truth within `margin_m` of the map, wherever an alignment with these limits may move it: a small map of a large
/// hall then costs little.
FloorTruth CroppedTo(const FloorPicture& map, const FloorTruth& truth, const FloorMotion& X_WV, double margin_m,
                     const FloorAlignmentOptions& limits);

/// The cells that were mapped, and what is true there.
struct FloorOverlap {
  cv::Mat map, truth;  ///< CV_32FC1, of the map's size.
  cv::Mat both;        ///< CV_8UC1: 255 where there are both.
  int64_t mapped = 0;  ///< Cells, also those beyond the floor.

  FloorOverlap(const FloorPicture& picture, const TrueFloor& floor, const FloorMotion& X_WV);

  Correlation Correlate() const;

  /// Each minus its mean over those of the `window` x `window` cells around that are in `both`.
  FloorOverlap WithoutLocalMean(int window) const;
};

/// An odd number of cells, at least 3, nearest to a side in metres.
int OddCells(double side_m, double cell_m);

}  // namespace gaitcam::internal
