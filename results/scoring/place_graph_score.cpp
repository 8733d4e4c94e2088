#include "results/scoring/place_graph_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// The path in steps of equal length, and the time of each.
struct SampledPath {
  std::vector<Vector2d> points;
  std::vector<int64_t> stamps;
  double step_m = 0;

  double LengthAt(size_t i) const { return step_m * double(i); }
  /// Last step begun by then.
  size_t IndexAt(int64_t stamp_ns) const {
    const auto after = std::upper_bound(stamps.begin(), stamps.end(), stamp_ns);
    return after == stamps.begin() ? 0 : size_t(after - stamps.begin() - 1);
  }
};

Vector2d PositionAt(const Trajectory& truth, int64_t stamp_ns) {
  const auto after = std::lower_bound(truth.begin(), truth.end(), stamp_ns,
                                      [](const auto& pose, int64_t stamp) { return pose.stamp_ns < stamp; });
  return (after == truth.end() ? truth.back() : *after).pose.translation.head<2>();
}

SampledPath SamplePath(const Trajectory& truth, double step_m) {
  SampledPath path;
  path.step_m = step_m;
  for (const auto& pose : truth) {
    const Vector2d p = pose.pose.translation.head<2>();
    const auto add = [&](const Vector2d& at, int64_t stamp_ns) {
      path.points.push_back(at);
      path.stamps.push_back(stamp_ns);
    };
    if (path.points.empty()) add(p, pose.stamp_ns);
    const Vector2d from = path.points.back(), way = p - from;
    const int64_t from_ns = path.stamps.back(), time_ns = pose.stamp_ns - from_ns;
    const int between = int(way.norm() / step_m) - 1;  // a film of few frames: straight from one to the next
    for (int k = 1; k <= between; ++k) {
      const double part = k * step_m / way.norm();
      add(from + part * way, from_ns + int64_t(part * double(time_ns)));
    }
    if (way.norm() >= step_m) add(p, pose.stamp_ns);
  }
  return path;
}

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Where two segments cross.
std::optional<Vector2d> Crossing(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double across = Cross(b - a, d - c);
  if (std::abs(across) < 1e-12) return std::nullopt;
  const double s = Cross(c - a, d - c) / across, t = Cross(c - a, b - a) / across;
  if (s < 0 || s >= 1 || t < 0 || t >= 1) return std::nullopt;
  return a + s * (b - a);
}

/// Where two passes run into one another they cross several times within a step or two: that is one crossing.
std::vector<Revisit> CrossingsOf(const SampledPath& path, const PlaceGraphScoreOptions& options) {
  std::vector<Revisit> crossings;
  for (size_t j = 1; j + 1 < path.points.size(); ++j) {
    for (size_t i = 0; i + 1 < j; ++i) {
      const double first_m = path.LengthAt(i), again_m = path.LengthAt(j);
      if (again_m - first_m < options.min_return_m) break;
      const auto at = Crossing(path.points[i], path.points[i + 1], path.points[j], path.points[j + 1]);
      if (!at) continue;
      const bool known = std::any_of(crossings.begin(), crossings.end(), [&](const Revisit& c) {
        return std::abs(c.return_m - again_m) < options.same_place_m && (c.at_m - *at).norm() < options.same_place_m;
      });
      if (!known) crossings.push_back({*at, first_m, again_m});
    }
  }
  return crossings;
}

/// Each node's later passes: maximal stretches within half of `same_place_m` of it.
std::vector<Revisit> ReturnsOf(const SampledPath& path, const PlaceGraph& graph, const std::vector<Vector2d>& nodes_m,
                               const PlaceGraphScoreOptions& options) {
  std::vector<Revisit> returns;
  for (size_t n = 0; n < nodes_m.size(); ++n) {
    const double made_m = path.LengthAt(path.IndexAt(graph.nodes[n].stamp_ns));
    double last_near_m = made_m;
    for (size_t i = 0; i < path.points.size(); ++i) {
      const double here_m = path.LengthAt(i);
      if (here_m <= made_m || (path.points[i] - nodes_m[n]).norm() > 0.5 * options.same_place_m) continue;
      if (here_m - last_near_m > options.min_return_m) returns.push_back({nodes_m[n], made_m, here_m});
      last_near_m = here_m;
    }
  }
  return returns;
}

/// A right loop is worth one return: of those near it, the one whose place is nearest to where it was closed.
void MarkFound(const SampledPath& path, const std::vector<ClosedLoop>& loops, const std::vector<Vector2d>& nodes_m,
               const PlaceGraphScoreOptions& options, std::vector<Revisit>& revisits) {
  for (const ClosedLoop& loop : loops) {
    const double here_m = path.LengthAt(path.IndexAt(loop.stamp_ns));
    Revisit* nearest = nullptr;
    for (Revisit& revisit : revisits) {
      if (!loop.right || std::abs(here_m - revisit.return_m) > 2 * options.same_place_m ||
          (nodes_m[size_t(loop.to)] - revisit.at_m).norm() > 1.5 * options.same_place_m) {
        continue;
      }
      if (!nearest || (revisit.at_m - loop.at_m).norm() < (nearest->at_m - loop.at_m).norm()) nearest = &revisit;
    }
    if (nearest) nearest->found = true;
  }
}

double Ratio(double part, double whole) { return whole > 0 ? part / whole : std::numeric_limits<double>::quiet_NaN(); }

double Found(const std::vector<Revisit>& revisits) {
  return double(std::count_if(revisits.begin(), revisits.end(), [](const Revisit& r) { return r.found; }));
}

double RightLoops(const PlaceGraphComparison& comparison) {
  return double(std::count_if(comparison.loops.begin(), comparison.loops.end(),
                              [](const ClosedLoop& loop) { return loop.right; }));
}

double MeanNodeBytes(const PlaceGraph& graph) {
  double bytes = 0;
  for (const PlaceNode& node : graph.nodes) bytes += double(node.bytes);
  return Ratio(bytes, double(graph.nodes.size()));
}

double MaxLoopDistance(const PlaceGraphComparison& comparison) {
  double max_m = 0;
  for (const ClosedLoop& loop : comparison.loops) max_m = std::max(max_m, loop.distance_m);
  return max_m;
}

}  // namespace

PlaceGraphComparison ComparePlaceGraph(const PlaceGraph& graph, const Trajectory& truth,
                                       const PlaceGraphScoreOptions& options) {
  CheckFields(options, "places.");
  if (truth.empty()) throw TooLittleData("no true poses to compare a topological map with");
  const SampledPath path = SamplePath(truth, options.step_m);
  PlaceGraphComparison comparison;
  comparison.start_ns = truth.front().stamp_ns;
  comparison.path_m = path.points;
  for (const PlaceNode& node : graph.nodes) comparison.nodes_m.push_back(PositionAt(truth, node.stamp_ns));
  for (const PlaceLink& link : graph.links) {
    if (!link.loop) continue;
    ClosedLoop loop{link.from, link.to, link.stamp_ns, PositionAt(truth, link.stamp_ns)};
    loop.distance_m = (loop.at_m - comparison.nodes_m[size_t(link.to)]).norm();
    loop.right = loop.distance_m <= options.same_place_m;
    comparison.loops.push_back(loop);
  }
  comparison.crossings = CrossingsOf(path, options);
  comparison.returns = ReturnsOf(path, graph, comparison.nodes_m, options);
  MarkFound(path, comparison.loops, comparison.nodes_m, options, comparison.crossings);
  MarkFound(path, comparison.loops, comparison.nodes_m, options, comparison.returns);
  comparison.scores = Evaluate(PlaceGraphMetrics(), {graph, comparison});
  return comparison;
}

std::vector<Metric<PlaceGraphEvidence>> PlaceGraphMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kLoops;
  return {{"place_nodes", "", Better::kNeither, kGroup, "places of the map",
           [](const auto& e) { return double(e.graph.nodes.size()); }, true},
          {"place_node_bytes", "byte", Better::kLower, kGroup, "memory that a place takes",
           [](const auto& e) { return MeanNodeBytes(e.graph); }},
          {"place_tests", "", Better::kNeither, kGroup, "tries to recognise a place",
           [](const auto& e) { return double(e.graph.tests.size()); }},
          {"loops_closed", "", Better::kNeither, kGroup, "loops that the system closed",
           [](const auto& e) { return double(e.comparison.loops.size()); }, true},
          {"loops_false", "", Better::kLower, kGroup, "of those, to a place that the robot was not at",
           [](const auto& e) { return double(e.comparison.loops.size()) - RightLoops(e.comparison); }, true},
          {"loop_precision", "", Better::kHigher, kGroup, "right ones of the loops closed",
           [](const auto& e) { return Ratio(RightLoops(e.comparison), double(e.comparison.loops.size())); }, true},
          {"loop_crossings", "", Better::kNeither, kGroup, "the true way crosses itself so often",
           [](const auto& e) { return double(e.comparison.crossings.size()); }},
          {"loop_crossings_found", "", Better::kHigher, kGroup, "crossings at which a right loop was closed",
           [](const auto& e) { return Found(e.comparison.crossings); }},
          {"loop_returns", "", Better::kNeither, kGroup, "known places that the true way passes anew",
           [](const auto& e) { return double(e.comparison.returns.size()); }},
          {"loop_recall", "", Better::kHigher, kGroup, "returns at which a right loop was closed",
           [](const auto& e) { return Ratio(Found(e.comparison.returns), double(e.comparison.returns.size())); }, true},
          {"loop_distance_max_m", "m", Better::kLower, kGroup,
           "farthest that the robot was from a place that it recognised",
           [](const auto& e) { return MaxLoopDistance(e.comparison); }}};
}

}  // namespace gaitcam
