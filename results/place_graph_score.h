/// A topological map against the true way: were loops closed where the way came back, and only there?

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/place_graph.h"
#include "algorithms/core/trajectory.h"
#include "results/score.h"

namespace gaitcam {

struct PlaceGraphScoreOptions {
  using DescribedTag = void;
  double same_place_m = 0.6;  ///< A loop is right if the robot is no farther than this from the place that it names.
  double step_m = 0.1;        ///< The way is looked at so often: head scans and swaying are no way.
  double least_way_m = 1.5;   ///< Way between two visits; less is no coming back.
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceGraphScoreOptions& o) {
  visit("same_place_m", o.same_place_m, Between(0.01, 100.0), "distance up to which a loop is right");
  visit("step_m", o.step_m, Between(0.001, 10.0), "the way is looked at so often");
  visit("least_way_m", o.least_way_m, Between(0.1, 1000.0), "way between two visits of a place");
}

/// A loop that the system closed.
struct ClosedLoop {
  int from = 0, to = 0;  ///< Nodes.
  int64_t stamp_ns = 0;
  Eigen::Vector2d at_m{0, 0};  ///< Where the robot was.
  double distance_m = 0;       ///< From there to the place.
  bool right = false;
};

/// Where the way meets itself again: it crosses, or comes along.
struct Revisit {
  Eigen::Vector2d at_m{0, 0};
  double first_way_m = 0, again_way_m = 0;  ///< Way walked until then.
  bool found = false;                       ///< A right loop was closed there.
};

struct PlaceGraphComparison {
  std::vector<Eigen::Vector2d> way_m;    ///< The true way, step by step.
  std::vector<Eigen::Vector2d> nodes_m;  ///< True places.
  std::vector<ClosedLoop> loops;
  std::vector<Revisit> crossings;  ///< Where the way crosses itself.
  std::vector<Revisit> returns;    ///< Stretches along which it passes a known place anew.
  std::vector<Score> scores;       ///< `place_...` and `loop_...`.
};

/// @param truth poses of the camera or robot, in time order. @throws BadOption; TooLittleData without truth.
PlaceGraphComparison ComparePlaceGraph(const PlaceGraph& graph, const Trajectory& truth,
                                       const PlaceGraphScoreOptions& options = {});

}  // namespace gaitcam
