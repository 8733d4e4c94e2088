/// The mapped floor on a run's page: beside the true one, with the paths drawn on both. A section of report.h's page.

#pragma once

#include <string>
#include <vector>

#include "algorithms/core/trajectory.h"
#include "results/reports/report_section.h"
#include "results/scoring/floor_score.h"

namespace gaitcam {

/// Nothing if the map is empty. @param estimate the system's path after SE(3) alignment: it is drawn where the
/// pictures' alignment puts it, as the map is.
ReportSection FloorReportSection(const FloorComparison& map, const Trajectory& truth, const Trajectory& estimate);

}  // namespace gaitcam

namespace gaitcam::internal {

/// A path seen from above, in pieces where there was no pose for a while.
using PlanePath = std::vector<std::vector<Eigen::Vector2d>>;

/// @param X_WV moves the path on the floor.
PlanePath FloorPath(const Trajectory& trajectory, const FloorMotion& X_WV);

/// @pre the map is not empty.
std::string MapSection(const FloorComparison& map, const PlanePath& truth, const PlanePath& estimate);
std::string MapCards(const FloorComparison& map);

}  // namespace gaitcam::internal
