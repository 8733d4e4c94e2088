/// A pose graph on a run's page: its poses with their covariances and its links, over the true path. A section of
/// report.h's page.

#pragma once

#include "algorithms/core/pose_graph.h"
#include "algorithms/core/trajectory.h"
#include "results/reports/report_section.h"
#include "results/scoring/alignment.h"
#include "results/scoring/pose_graph_score.h"

namespace gaitcam {

/// @param X_WV moves the graph's world into that of the truth.
ReportSection PoseGraphReportSection(const PoseGraphComparison& comparison, const PoseGraph& graph,
                                     const Trajectory& truth, const Similarity& X_WV);

}  // namespace gaitcam
