#include "results/place_graph_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// The way in steps of equal length, and the time of each.
struct Way {
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

Way WayOf(const Trajectory& truth, double step_m) {
  Way way;
  way.step_m = step_m;
  for (const auto& pose : truth) {
    const Vector2d p = pose.pose.translation.head<2>();
    if (!way.points.empty() && (p - way.points.back()).norm() < step_m) continue;
    way.points.push_back(p);
    way.stamps.push_back(pose.stamp_ns);
  }
  return way;
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

/// Ways that run into one another cross several times within a step or two: that is one crossing.
std::vector<Revisit> CrossingsOf(const Way& way, const PlaceGraphScoreOptions& options) {
  std::vector<Revisit> crossings;
  for (size_t j = 1; j + 1 < way.points.size(); ++j) {
    for (size_t i = 0; i + 1 < j; ++i) {
      const double first_m = way.LengthAt(i), again_m = way.LengthAt(j);
      if (again_m - first_m < options.least_way_m) break;
      const auto at = Crossing(way.points[i], way.points[i + 1], way.points[j], way.points[j + 1]);
      if (!at) continue;
      const bool known = std::any_of(crossings.begin(), crossings.end(), [&](const Revisit& c) {
        return std::abs(c.again_way_m - again_m) < options.same_place_m && (c.at_m - *at).norm() < options.same_place_m;
      });
      if (!known) crossings.push_back({*at, first_m, again_m});
    }
  }
  return crossings;
}

/// Each node's later passes: maximal stretches within half of `same_place_m` of it.
std::vector<Revisit> ReturnsOf(const Way& way, const PlaceGraph& graph, const std::vector<Vector2d>& nodes_m,
                               const PlaceGraphScoreOptions& options) {
  std::vector<Revisit> returns;
  for (size_t n = 0; n < nodes_m.size(); ++n) {
    const double made_m = way.LengthAt(way.IndexAt(graph.nodes[n].stamp_ns));
    double last_near_m = made_m;
    for (size_t i = 0; i < way.points.size(); ++i) {
      const double here_m = way.LengthAt(i);
      if (here_m <= made_m || (way.points[i] - nodes_m[n]).norm() > 0.5 * options.same_place_m) continue;
      if (here_m - last_near_m > options.least_way_m) returns.push_back({nodes_m[n], made_m, here_m});
      last_near_m = here_m;
    }
  }
  return returns;
}

/// A right loop is worth one return: of those near it, the one whose place is nearest to where it was closed.
void MarkFound(const Way& way, const std::vector<ClosedLoop>& loops, const std::vector<Vector2d>& nodes_m,
               const PlaceGraphScoreOptions& options, std::vector<Revisit>& revisits) {
  for (const ClosedLoop& loop : loops) {
    const double way_m = way.LengthAt(way.IndexAt(loop.stamp_ns));
    Revisit* nearest = nullptr;
    for (Revisit& revisit : revisits) {
      if (!loop.right || std::abs(way_m - revisit.again_way_m) > 2 * options.same_place_m ||
          (nodes_m[size_t(loop.to)] - revisit.at_m).norm() > 1.5 * options.same_place_m) {
        continue;
      }
      if (!nearest || (revisit.at_m - loop.at_m).norm() < (nearest->at_m - loop.at_m).norm()) nearest = &revisit;
    }
    if (nearest) nearest->found = true;
  }
}

double Ratio(double part, double whole) { return whole > 0 ? part / whole : std::numeric_limits<double>::quiet_NaN(); }

void AddScores(const PlaceGraph& graph, PlaceGraphComparison& comparison) {
  const auto found = [](const std::vector<Revisit>& revisits) {
    return double(std::count_if(revisits.begin(), revisits.end(), [](const Revisit& r) { return r.found; }));
  };
  double bytes = 0, right = 0, farthest_m = 0;
  for (const PlaceNode& node : graph.nodes) bytes += double(node.bytes);
  for (const ClosedLoop& loop : comparison.loops) {
    right += loop.right;
    farthest_m = std::max(farthest_m, loop.distance_m);
  }
  const double loops = double(comparison.loops.size()), nodes = double(graph.nodes.size());
  comparison.scores = {
      {"place_nodes", nodes, "", "places seen all around", Better::kNeither},
      {"place_node_bytes", Ratio(bytes, nodes), "byte", "memory that a place takes", Better::kLower},
      {"place_tests", double(graph.tests.size()), "", "tries to recognise a place", Better::kNeither},
      {"loops_closed", loops, "", "loops that the system closed", Better::kNeither},
      {"loops_false", loops - right, "", "of those, to a place that the robot was not at", Better::kLower},
      {"loop_precision", Ratio(right, loops), "", "right ones of the loops closed", Better::kHigher},
      {"loop_crossings", double(comparison.crossings.size()), "", "the true way crosses itself so often",
       Better::kNeither},
      {"loop_crossings_found", found(comparison.crossings), "", "crossings at which a right loop was closed",
       Better::kHigher},
      {"loop_returns", double(comparison.returns.size()), "", "known places that the true way passes anew",
       Better::kNeither},
      {"loop_recall", Ratio(found(comparison.returns), double(comparison.returns.size())), "",
       "returns at which a right loop was closed", Better::kHigher},
      {"loop_distance_max_m", farthest_m, "m", "farthest that the robot was from a place that it recognised",
       Better::kLower}};
}

}  // namespace

PlaceGraphComparison ComparePlaceGraph(const PlaceGraph& graph, const Trajectory& truth,
                                       const PlaceGraphScoreOptions& options) {
  CheckFields(options, "places.");
  if (truth.empty()) throw TooLittleData("no true poses to compare a topological map with");
  const Way way = WayOf(truth, options.step_m);
  PlaceGraphComparison comparison;
  comparison.way_m = way.points;
  for (const PlaceNode& node : graph.nodes) comparison.nodes_m.push_back(PositionAt(truth, node.stamp_ns));
  for (const PlaceLink& link : graph.links) {
    if (!link.loop) continue;
    ClosedLoop loop{link.from, link.to, link.stamp_ns, PositionAt(truth, link.stamp_ns)};
    loop.distance_m = (loop.at_m - comparison.nodes_m[size_t(link.to)]).norm();
    loop.right = loop.distance_m <= options.same_place_m;
    comparison.loops.push_back(loop);
  }
  comparison.crossings = CrossingsOf(way, options);
  comparison.returns = ReturnsOf(way, graph, comparison.nodes_m, options);
  MarkFound(way, comparison.loops, comparison.nodes_m, options, comparison.crossings);
  MarkFound(way, comparison.loops, comparison.nodes_m, options, comparison.returns);
  AddScores(graph, comparison);
  return comparison;
}

}  // namespace gaitcam
