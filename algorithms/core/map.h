/// The kinds of map that a system may hand over. A map is a value: it knows nothing of the system that made it.
///
/// What is done with maps (scores, files, a section of the report) stands in one table with an entry for each kind,
/// scenarios/code/runs/map_results.h; a kind that is added here and not there does not compile.

#pragma once

#include <string>
#include <variant>
#include <vector>

#include "algorithms/core/floor_picture.h"
#include "algorithms/core/landmark_map.h"
#include "algorithms/core/occupancy_grid.h"
#include "algorithms/core/place_graph.h"
#include "algorithms/core/pose_graph.h"
#include "algorithms/core/route_map.h"
#include "algorithms/core/taught_drive.h"

namespace gaitcam {

using Map = std::variant<FloorPicture, PlaceGraph, LandmarkMap, OccupancyGrid, PoseGraph, RouteMap, TaughtDrive>;

/// The first map of one kind, or null.
template <class Kind>
const Kind* FindMap(const std::vector<Map>& maps) {
  for (const Map& map : maps) {
    if (const Kind* found = std::get_if<Kind>(&map)) return found;
  }
  return nullptr;
}

}  // namespace gaitcam
