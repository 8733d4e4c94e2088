/// The mapped floor on a run's page: beside the true one, with the paths drawn on both. An inner part of report.cpp.

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "algorithms/core/trajectory.h"
#include "results/floor_score.h"

namespace gaitcam::internal {

/// A path seen from above, in pieces where there was no pose for a while.
using PlanePath = std::vector<std::vector<Eigen::Vector2d>>;

/// @param X_WV moves the path on the floor.
PlanePath FloorPath(const Trajectory& trajectory, const FloorMotion& X_WV);

/// @pre the map is not empty.
std::string MapSection(const FloorComparison& map, const PlanePath& truth, const PlanePath& estimate);
std::string MapCards(const FloorComparison& map);

/// CSS.
std::string_view MapStyle();

}  // namespace gaitcam::internal
