/// A topological map on a run's page: drawn over the true path, with its loops and what decided them. A section of
/// report.h's page.

#pragma once

#include <string>

#include "algorithms/core/place_graph.h"
#include "results/reports/report_section.h"
#include "results/scoring/place_graph_score.h"

namespace gaitcam {

ReportSection PlaceReportSection(const PlaceGraphComparison& comparison, const PlaceGraph& graph);

}  // namespace gaitcam

namespace gaitcam::internal {

std::string PlaceSection(const PlaceGraphComparison& comparison, const PlaceGraph& graph);
std::string PlaceCards(const PlaceGraphComparison& comparison, const PlaceGraph& graph);

}  // namespace gaitcam::internal
