/// A topological map as GraphML, which graph programs read: http://graphml.graphdrawing.org.
///
/// Nodes carry stamp_ns and bytes, edges stamp_ns and loop; nodes also x_m and y_m, where the caller knows positions:
/// estimated ones, or those of the truth, which no system has.

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "algorithms/core/place_graph.h"

namespace gaitcam {

/// @param positions_m of the nodes, in their order; or none at all. Panoramas and tests are not written.
/// @throws MissingResource if the file cannot be written.
void WritePlaceGraph(const std::filesystem::path& file, const PlaceGraph& graph,
                     const std::vector<Eigen::Vector2d>& positions_m = {});

struct PlaceGraphFile {
  PlaceGraph graph;
  std::vector<Eigen::Vector2d> positions_m;  ///< Of all nodes, or empty.
};

/// What WritePlaceGraph wrote. @throws BadInput naming file, line and what is wrong.
PlaceGraphFile ReadPlaceGraph(const std::filesystem::path& file);

}  // namespace gaitcam
