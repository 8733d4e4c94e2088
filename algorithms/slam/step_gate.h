/// Which known places can the robot have walked to? By dead reckoning in steps (step_dead_reckoning.h): scenes that
/// repeat themselves are told apart by nothing else.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/observation.h"
#include "algorithms/odometry/step_dead_reckoning.h"

namespace gaitcam {

class StepGate {
 public:
  struct Options {
    double reach_steps = 20;  ///< A place is out of reach if it lies farther away, by counted steps, ...
    double error = 0.04;      ///< ... than this and such a share of the steps made since it was visited.
  };

  explicit StepGate(const Options& options) : options_(options) {}

  /// @param heading_rad while these samples were taken, left positive, not wrapped.
  void Walk(const std::vector<JointSample>& samples, double heading_rad) { steps_.Add(samples, heading_rad); }
  /// A new node, where the robot stands.
  void AddNode();
  /// The robot is at a node again: reckoning goes on from there.
  void Visit(int node);
  /// Whether the robot may be at a node. Without foot switches nothing is out of reach.
  bool InReach(int node) const;

 private:
  struct Visited {
    Eigen::Vector2d position{0, 0};  ///< Steps.
    int steps = 0;                   ///< Made until the robot was there last.
  };

  Options options_;
  StepDeadReckoning steps_;
  std::vector<Visited> nodes_;
};

}  // namespace gaitcam
