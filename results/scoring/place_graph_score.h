/// A topological map against the true path: were loops closed where the path returns to a place, and only there?

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/place_graph.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/metric.h"

namespace gaitcam {

struct PlaceGraphScoreOptions {
  using DescribedTag = void;
  double same_place_m = 0.6;
  double step_m = 0.1;
  double min_return_m = 1.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceGraphScoreOptions& o) {
  visit("same_place_m", o.same_place_m, Between(0.01, 100.0),
        "a loop is right if the robot is no farther than this from the place that it names");
  visit("step_m", o.step_m, Between(0.001, 10.0),
        "the path is sampled at this distance, so that head scans and swaying do not add to it");
  visit("min_return_m", o.min_return_m, Between(0.1, 1000.0), "path length between two visits of a place");
}

/// A loop that the system closed.
struct ClosedLoop {
  int from = 0, to = 0;  ///< Nodes.
  int64_t stamp_ns = 0;
  Eigen::Vector2d at_m{0, 0};  ///< Where the robot was.
  double distance_m = 0;       ///< From there to the place.
  bool right = false;
};

/// Where the path meets itself again: it crosses itself, or passes a place anew.
struct Revisit {
  Eigen::Vector2d at_m{0, 0};
  double first_m = 0, return_m = 0;  ///< Path length until then.
  bool found = false;                ///< A right loop was closed there.
};

struct PlaceGraphComparison {
  int64_t start_ns = 0;                  ///< The first true pose.
  std::vector<Eigen::Vector2d> path_m;   ///< The true path, step by step.
  std::vector<Eigen::Vector2d> nodes_m;  ///< True places.
  std::vector<ClosedLoop> loops;
  std::vector<Revisit> crossings;  ///< Where the path crosses itself.
  std::vector<Revisit> returns;    ///< Stretches along which it passes a known place anew.
  std::vector<Score> scores;       ///< `place_...` and `loop_...`.
};

/// @param truth poses of the camera or robot, in time order. @throws BadOption; TooLittleData without truth.
PlaceGraphComparison ComparePlaceGraph(const PlaceGraph& graph, const Trajectory& truth,
                                       const PlaceGraphScoreOptions& options = {});

/// What the metrics of a topological map take their values from.
struct PlaceGraphEvidence {
  const PlaceGraph& graph;
  const PlaceGraphComparison& comparison;
};
std::vector<Metric<PlaceGraphEvidence>> PlaceGraphMetrics();

}  // namespace gaitcam
