/// A pose graph against the true path: are the loops that it keeps true, and how many poses does it need?

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/pose_graph.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/metric.h"

namespace gaitcam {

struct PoseGraphScoreOptions {
  using DescribedTag = void;
  double loop_m = 0.1;
  double loop_deg = 5;
};

template <class Visitor>
void VisitFields(Visitor& visit, PoseGraphScoreOptions& o) {
  visit("loop_m", o.loop_m, Between(0.001, 100), "a loop is false if its motion is wrong by more than this ...");
  visit("loop_deg", o.loop_deg, Between(0.01, 180), "... or turned by more than this");
}

/// A loop closure of the graph.
struct JudgedLoop {
  int link = 0;                       ///< Of PoseGraph::links.
  double error_m = 0, error_deg = 0;  ///< Of its motion; NaN without truth at one of its ends.
  bool right = false;
  bool kept = false;  ///< The graph trusts it.
};

struct PoseGraphComparison {
  std::vector<JudgedLoop> loops;
  std::vector<Score> scores;  ///< `graph_...`.
};

/// @param truth poses of the camera, in time order. @throws BadOption.
PoseGraphComparison ComparePoseGraph(const PoseGraph& graph, const Trajectory& truth,
                                     const PoseGraphScoreOptions& options = {});

struct PoseGraphEvidence {
  const PoseGraph& graph;
  const std::vector<JudgedLoop>& loops;
};
std::vector<Metric<PoseGraphEvidence>> PoseGraphMetrics();

}  // namespace gaitcam
