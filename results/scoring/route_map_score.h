/// A map of one or several sessions against where the camera truly was: do the sessions lie right to each other?

#pragma once

#include <vector>

#include "algorithms/core/route_map.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/metric.h"
#include "results/scoring/pose_graph_score.h"

namespace gaitcam {

struct RouteMapComparison {
  std::vector<JudgedLoop> joins;  ///< Links from one session to another.
  std::vector<double> error_m;    ///< Of each view with a true position, after one alignment of all sessions together.
  std::vector<Score> scores;      ///< `route_...`.
};

/// @param truth X_WC of the camera over all sessions, stamps as the map's.
RouteMapComparison CompareRouteMap(const RouteMap& map, const Trajectory& truth);

struct RouteMapEvidence {
  const RouteMap& map;
  const RouteMapComparison& comparison;
};
std::vector<Metric<RouteMapEvidence>> RouteMapMetrics();

}  // namespace gaitcam
