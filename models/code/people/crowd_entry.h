/// A crowd in a scene: how many people, what they do, how fast they walk, and where to.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/option_reader.h"

namespace gaitcam {

/// One crowd, as a scene's or a scenario's `crowd` says it. How it moves follows from this, the room, the robot's
/// course and a seed: see crowd.h.
///
///   crowd: {count: 40, standing: 0.1, talking: 0.25, speed_m_s: 1.2}
struct CrowdEntry {
  using DescribedTag = void;
  int count = 20;
  std::optional<uint64_t> seed;
  double standing = 0.1;
  double talking = 0.2;
  double sitting = 0;
  double queueing = 0;
  double speed_m_s = 1.29;
  double speed_sigma_m_s = 0.19;
  Eigen::Vector2d stay_s{2, 10};
  Eigen::Vector2d leave_s{0, 0};
  std::vector<Eigen::Vector2d> goals;
  double keep_off_m = 0.7;
  Eigen::Vector2d height_m{1.5, 1.95};
};

template <class Visitor>
void VisitFields(Visitor& visit, CrowdEntry& o) {
  visit("count", o.count, Between(0, 500), "how many people");
  visit("seed", o.seed, Nested(), "of who they are and where they go; absent: the run's");
  visit("standing", o.standing, Between(0, 1), "share of them who stand by themselves");
  visit("talking", o.talking, Between(0, 1), "share of them who stand and talk, in groups of two to four");
  visit("sitting", o.sitting, Between(0, 1), "share of them who sit, on chairs and benches of the scene");
  visit("queueing", o.queueing, Between(0, 1), "share of them who stand in a queue; those who are left over walk");
  visit("speed_m_s", o.speed_m_s, Between(0.4, 1.8),
        "mean of the speeds that walkers prefer (1.29: Moussaid et al., 2009)");
  visit("speed_sigma_m_s", o.speed_sigma_m_s, Between(0, 0.4), "their standard deviation");
  visit("stay_s", o.stay_s, Nested(), "shortest and longest stay at a goal before a walker goes on to the next");
  visit("leave_s", o.leave_s, Nested(),
        "when those who stand or talk walk off, each group together: first and last; [0, 0]: never");
  visit("goals", o.goals, Nested(),
        "where walkers go, [[x m, y m], ...]; absent: random free places, and places before posters and furniture");
  visit("keep_off_m", o.keep_off_m, Between(0.3, 3),
        "between the robot's middle and that of a person: they walk round it");
  visit("height_m", o.height_m, Nested(), "of the shortest and the tallest");
}

/// Reads and checks what the ranges of single fields do not say. @throws BadInput naming file, line and key.
void ReadOption(const OptionValue& node, CrowdEntry& crowd);

}  // namespace gaitcam
