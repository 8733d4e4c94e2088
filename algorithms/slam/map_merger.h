/// Several sessions in one map: another day, other light, other people.
///
/// Source: Hua, section 6.1.1, which names the merging of recordings as a use of the map and leaves open how. Here
/// views of the later session are looked for among those of the earlier map as loops are (hybrid_loops.h). Each that is
/// found says where the later session's world lies in the earlier one; those that agree with one another most join the
/// two, and all is solved as one pose graph in which joins, too, may lose their trust.

#pragma once

#include <cstdint>
#include <optional>

#include "algorithms/core/camera.h"
#include "algorithms/core/route_map.h"
#include "algorithms/slam/hybrid_loops.h"
#include "algorithms/slam/metric_model.h"

namespace gaitcam {

struct MapMergeOptions {
  PassSearchOptions search;
  ModelLinkOptions links;
  MetricModelOptions models;
  int min_joins = 5;     ///< That agree; fewer may be chance.
  double agree_m = 0.5;  ///< So near each other two joins put a view of the later session; it may have drifted ...
  double agree_deg = 5;  ///< ... and turned.
};

/// Its world is the earlier map's; stamps of the later session go on by a day for each session before it.
/// @param earlier of any number of sessions. @param later of one. @param feature of both.
/// @returns nothing where the later session met the earlier map too seldom.
/// @throws BadInput as ModelsOf.
std::optional<RouteMap> MergeRouteMaps(const RouteMap& earlier, const RouteMap& later, const Calibration& calibration,
                                       const MapMergeOptions& options, uint64_t seed);

}  // namespace gaitcam
