/// An occupancy grid as ROS's map_server reads it (wiki.ros.org/map_server): a YAML file that names an image.
///
///   image: grid.png            8 bit grey, 255 (1 - p): white is free, black is occupied
///   resolution: 0.05           m per pixel
///   origin: [x, y, 0]          of the lower left corner of the image, m; yaw 0
///   negate: 0
///   occupied_thresh: 0.65      p above it: occupied
///   free_thresh: 0.196         p below it: free; between the two: unknown
///
/// What is unknown (log-odds 0) is grey level 128. Eight bits keep p to 1/510; p is never written nearer to 0 or 1 than
/// that.

#pragma once

#include <filesystem>

#include "algorithms/core/occupancy_grid.h"

namespace gaitcam {

/// Writes `yaml` and the image beside it, of the same name with .png. @throws MissingResource if they cannot be
/// written. @pre the grid is not empty.
void WriteOccupancyGrid(const std::filesystem::path& yaml, const OccupancyGrid& grid);

/// Our own, or one of map_server's with yaw 0; `negate: 1` (white is occupied) is understood.
/// @throws BadInput naming file, line, key and what would be right.
OccupancyGrid ReadOccupancyGrid(const std::filesystem::path& yaml);

}  // namespace gaitcam
