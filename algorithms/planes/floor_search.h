/// Global registration of a small map of the floor (a submap) in a large one.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/floor_picture.h"
#include "algorithms/core/planar_pose.h"

namespace gaitcam {

/// A candidate pose of the submap.
struct FloorFind {
  PlanarPose X_MS;         ///< Maps the submap's coordinates into the map's.
  double correlation = 0;  ///< Of the cells that both cover, -1..1.
};

struct FloorSearchRange {
  PlanarPose X_MS;          ///< Expected.
  double reach_m = 1;       ///< Distance of its centre from the expected position ...
  double reach_rad = 0.1;   ///< ... and of its heading from the expected one.
  double step_rad = 0.035;  ///< Between the headings tried.
};

/// Normalised cross-correlation of two images with unknown cells, at all shifts at once for each heading: means and
/// variances are of the common cells alone (masked correlation by Fourier transform, Padfield 2012). Peaks, best first,
/// no two within three cells of each other.
/// @param map, submap of the same cell size. @param min_cells that both must cover.
std::vector<FloorFind> SearchFloor(const FloorPicture& map, const FloorPicture& submap, const FloorSearchRange& range,
                                   int min_cells, int max_finds);

}  // namespace gaitcam
