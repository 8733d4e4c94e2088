/// A topological map on a run's page: drawn over the true way, with its loops and what decided them. An inner part of
/// report.cpp.

#pragma once

#include <string>
#include <string_view>

#include "algorithms/core/place_graph.h"
#include "results/place_graph_score.h"

namespace gaitcam::internal {

std::string PlaceSection(const PlaceGraphComparison& comparison, const PlaceGraph& graph);
std::string PlaceCards(const PlaceGraphComparison& comparison);

/// CSS.
std::string_view PlaceStyle();

}  // namespace gaitcam::internal
