#include "algorithms/slam/map_merger.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/estimation/pose_graph_solver.h"

namespace gaitcam {
namespace {

/// The best link of a later view with each pass of the earlier map; `to` is the later view.
std::vector<GraphLink> FindJoins(const std::vector<MetricModel>& earlier, const std::vector<MetricModel>& later,
                                 const MapMergeOptions& options, RandomStream& random) {
  PassSearch search(options.search);
  for (const MetricModel& model : earlier) search.Add(model.features.descriptors);
  std::vector<GraphLink> joins;
  for (int to = 0; to < int(later.size()); ++to) {
    const MetricModel& seen = later[size_t(to)];
    if (int(seen.p_C.size()) < options.links.min_inliers) continue;
    for (const std::vector<int>& pass : search.BestOfEachPass(seen.features.descriptors, search.size())) {
      std::optional<ModelLink> best;
      int from = -1;
      for (const int view : pass) {
        const auto link = LinkModels(earlier[size_t(view)], seen, options.links, random);
        if (link && (!best || link->inliers > best->inliers)) best = link, from = view;
      }
      if (best) joins.push_back({from, to, best->X_FT, best->covariance, true, 1, false});
    }
  }
  return joins;
}

/// The largest set of joins that agree with one of them on where the later session's views are.
class Consensus {
 public:
  Consensus(const PoseGraph& earlier, const PoseGraph& later, const std::vector<GraphLink>& joins,
            const MapMergeOptions& options)
      : later_(later), joins_(joins), options_(options) {
    for (const GraphLink& join : joins) {
      const Pose X_EC = earlier.nodes[size_t(join.from)].X_WC * join.X_FT;
      X_EL_.push_back(X_EC * later.nodes[size_t(join.to)].X_WC.Inverse());
    }
  }

  std::vector<size_t> Largest() const {
    std::vector<size_t> best;
    for (size_t i = 0; i < joins_.size(); ++i) {
      std::vector<size_t> agreed;
      for (size_t k = 0; k < joins_.size(); ++k) {
        if (Agree(i, k)) agreed.push_back(k);
      }
      if (agreed.size() <= best.size()) continue;
      best = std::move(agreed);
      best_ = i;
    }
    return best;
  }
  /// The world of the later session in the earlier one, by the join that most agree with. @pre after Largest.
  const Pose& X_EL() const { return X_EL_[best_]; }

 private:
  bool Agree(size_t i, size_t k) const {
    const Pose& X_LC = later_.nodes[size_t(joins_[k].to)].X_WC;
    const Pose a = X_EL_[i] * X_LC, b = X_EL_[k] * X_LC;
    return (a.translation - b.translation).norm() <= options_.agree_m &&
           kDegPerRad * RotationAngle(a.rotation, b.rotation) <= options_.agree_deg;
  }

  const PoseGraph& later_;
  const std::vector<GraphLink>& joins_;
  const MapMergeOptions& options_;
  std::vector<Pose> X_EL_;
  mutable size_t best_ = 0;
};

/// Its nodes and links behind those that are there.
void Append(const RouteMap& later, const Pose& X_EL, RouteMap& map) {
  const int first = int(map.graph.nodes.size());
  const int64_t later_by_ns = int64_t(map.sessions.size()) * kSessionApart_ns;
  map.sessions.push_back(first);
  for (GraphNode node : later.graph.nodes) {
    node.X_WC = X_EL * node.X_WC;
    node.stamp_ns += later_by_ns;
    map.graph.nodes.push_back(node);
  }
  for (GraphLink link : later.graph.links) {
    link.from += first;
    link.to += first;
    map.graph.links.push_back(link);
  }
  map.graph.candidates += later.graph.candidates;
  map.views.insert(map.views.end(), later.views.begin(), later.views.end());
}

}  // namespace

std::optional<RouteMap> MergeRouteMaps(const RouteMap& earlier, const RouteMap& later, const Calibration& calibration,
                                       const MapMergeOptions& options, uint64_t seed) {
  GAITCAM_ASSERT(later.sessions.size() == 1);
  RandomStream random(seed, "map_merger");
  const std::vector<MetricModel> before = ModelsOf(earlier, calibration, later.feature, options.models);
  const std::vector<MetricModel> seen = ModelsOf(later, calibration, later.feature, options.models);
  const std::vector<GraphLink> joins = FindJoins(before, seen, options, random);
  const Consensus consensus(earlier.graph, later.graph, joins, options);
  const std::vector<size_t> agreed = consensus.Largest();
  if (int(agreed.size()) < options.min_joins) return std::nullopt;
  RouteMap map = earlier;
  const int first = int(map.graph.nodes.size());
  Append(later, consensus.X_EL(), map);
  for (const size_t join : agreed) {
    map.graph.links.push_back(joins[join]);
    map.graph.links.back().to += first;
  }
  SolvePoseGraph(map.graph);
  const PoseGraphCovariances covariances(map.graph);
  for (size_t node = 0; node < map.graph.nodes.size(); ++node)
    map.graph.nodes[node].covariance = covariances.Of(int(node));
  return map;
}

}  // namespace gaitcam
