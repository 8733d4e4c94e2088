#include "results/scoring/route_map_score.h"

#include <algorithm>
#include <cmath>

#include "results/scoring/alignment.h"
#include "results/scoring/metrics.h"

namespace gaitcam {
namespace {

std::vector<double> ErrorsOf(const PoseGraph& graph, const Trajectory& truth) {
  std::vector<PosePair> pairs;
  for (const GraphNode& node : graph.nodes) {
    if (const auto X_WC = PoseAt(truth, node.stamp_ns)) pairs.push_back({node.stamp_ns, *X_WC, node.X_WC, {}});
  }
  if (pairs.empty()) return {};
  return PositionErrors(Apply(Align(pairs, Alignment::kSe3).X_WV, pairs));
}

double Trusted(const std::vector<JudgedLoop>& joins, bool wrong_only) {
  return double(std::count_if(joins.begin(), joins.end(), [&](const JudgedLoop& join) {
    return join.kept && (!wrong_only || (std::isfinite(join.error_m) && !join.right));
  }));
}

}  // namespace

RouteMapComparison CompareRouteMap(const RouteMap& map, const Trajectory& truth) {
  RouteMapComparison comparison;
  for (const JudgedLoop& loop : ComparePoseGraph(map.graph, truth).loops) {
    const GraphLink& link = map.graph.links[size_t(loop.link)];
    if (SessionOf(map, link.from) != SessionOf(map, link.to)) comparison.joins.push_back(loop);
  }
  comparison.error_m = ErrorsOf(map.graph, truth);
  comparison.scores = Evaluate(RouteMapMetrics(), {map, comparison});
  return comparison;
}

std::vector<Metric<RouteMapEvidence>> RouteMapMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kLoops;
  using E = RouteMapEvidence;
  return {{"route_sessions", "", Better::kNeither, kGroup, "walks that taught the map which is handed over",
           [](const E& e) { return double(e.map.sessions.size()); }},
          {"route_views", "", Better::kNeither, kGroup, "views of the map",
           [](const E& e) { return double(e.map.views.size()); }},
          {"route_joins", "", Better::kNeither, kGroup, "links between sessions that the map trusts",
           [](const E& e) { return Trusted(e.comparison.joins, false); }},
          {"route_joins_false", "", Better::kLower, kGroup, "of those, false: off by more than 0.1 m or 5 deg",
           [](const E& e) { return Trusted(e.comparison.joins, true); }},
          {"route_error_rmse_m", "m", Better::kLower, kGroup,
           "error of the views' positions after one alignment of all sessions together, root mean square",
           [](const E& e) { return Summarize(e.comparison.error_m).rmse; }}};
}

}  // namespace gaitcam
