#include "results/scoring/pose_graph_score.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

JudgedLoop Judge(const PoseGraph& graph, int number, const Trajectory& truth, const PoseGraphScoreOptions& options) {
  const GraphLink& link = graph.links[size_t(number)];
  JudgedLoop loop{number, kNaN, kNaN, false, link.trust > 0.5};
  const auto from = PoseAt(truth, graph.nodes[size_t(link.from)].stamp_ns);
  const auto to = PoseAt(truth, graph.nodes[size_t(link.to)].stamp_ns);
  if (!from || !to) return loop;
  const Pose X_FT = from->Inverse() * *to;
  loop.error_m = (link.X_FT.translation - X_FT.translation).norm();
  loop.error_deg = kDegPerRad * RotationAngle(link.X_FT.rotation, X_FT.rotation);
  loop.right = loop.error_m <= options.loop_m && loop.error_deg <= options.loop_deg;
  return loop;
}

double Count(const std::vector<JudgedLoop>& loops, bool right, bool kept) {
  return double(std::count_if(loops.begin(), loops.end(), [&](const JudgedLoop& loop) {
    return std::isfinite(loop.error_m) && loop.right == right && loop.kept == kept;
  }));
}

double PartKept(const PoseGraph& graph) {
  return graph.candidates > 0 ? double(graph.nodes.size()) / graph.candidates : kNaN;
}

/// Of the first link that leads to each node.
double PartSeen(const PoseGraph& graph) {
  std::map<int, bool> seen;
  for (const GraphLink& link : graph.links) {
    if (!link.loop) seen.emplace(link.to, !link.dead_reckoned);
  }
  const auto count = std::count_if(seen.begin(), seen.end(), [](const auto& node) { return node.second; });
  return seen.empty() ? kNaN : double(count) / double(seen.size());
}

}  // namespace

PoseGraphComparison ComparePoseGraph(const PoseGraph& graph, const Trajectory& truth,
                                     const PoseGraphScoreOptions& options) {
  CheckFields(options, "graph.");
  PoseGraphComparison comparison;
  for (int l = 0; l < int(graph.links.size()); ++l) {
    if (graph.links[size_t(l)].loop) comparison.loops.push_back(Judge(graph, l, truth, options));
  }
  comparison.scores = Evaluate(PoseGraphMetrics(), {graph, comparison.loops});
  return comparison;
}

std::vector<Metric<PoseGraphEvidence>> PoseGraphMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kLoops;
  return {{"graph_nodes", "", Better::kNeither, kGroup, "poses that the graph keeps",
           [](const auto& e) { return double(e.graph.nodes.size()); }, true},
          {"graph_nodes_ratio", "", Better::kLower, kGroup, "part of the keyframes that the graph keeps",
           [](const auto& e) { return PartKept(e.graph); }},
          {"graph_links_seen_ratio", "", Better::kHigher, kGroup,
           "part of the nodes that the camera measured the way to; to the others the body's odometry leads",
           [](const auto& e) { return PartSeen(e.graph); }},
          {"graph_loops", "", Better::kNeither, kGroup, "loops that the graph keeps and trusts",
           [](const auto& e) { return Count(e.loops, true, true) + Count(e.loops, false, true); }, true},
          {"graph_loops_false", "", Better::kLower, kGroup, "of those, false: off by more than 0.1 m or 5 deg",
           [](const auto& e) { return Count(e.loops, false, true); }, true},
          {"graph_loops_refused", "", Better::kNeither, kGroup, "false loops that the graph found to be so",
           [](const auto& e) { return Count(e.loops, false, false); }},
          {"graph_loops_lost", "", Better::kLower, kGroup, "true loops that the graph took for false",
           [](const auto& e) { return Count(e.loops, true, false); }}};
}

}  // namespace gaitcam
