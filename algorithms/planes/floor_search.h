/// Finds where a small picture of the floor lies in a large one, when it may lie far from where it is expected.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/floor_picture.h"
#include "algorithms/core/planar_pose.h"

namespace gaitcam {

/// A place where a piece could lie.
struct FloorFind {
  PlanarPose X_MP;         ///< Maps the piece's floor coordinates into the map's.
  double correlation = 0;  ///< Of the cells that both know, -1..1.
};

struct FloorSearchRange {
  PlanarPose X_MP;          ///< Expected; the piece is turned about its world's origin.
  double reach_m = 1;       ///< Its middle may lie so far from where that puts it ...
  double reach_rad = 0.1;   ///< ... and it may be turned so much otherwise.
  double step_rad = 0.035;  ///< From turn to turn.
};

/// Normalised cross-correlation of two pictures with holes, at all shifts at once and turn by turn: means and variances
/// are of the common cells alone (masked correlation by Fourier transform, Padfield 2012). Peaks, best first, no two
/// within three cells of each other.
/// @param map, piece of the same cell size. @param min_cells that both must know.
std::vector<FloorFind> SearchFloor(const FloorPicture& map, const FloorPicture& piece, const FloorSearchRange& range,
                                   int min_cells, int most);

}  // namespace gaitcam
