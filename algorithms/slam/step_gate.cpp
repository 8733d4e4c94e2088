#include "algorithms/slam/step_gate.h"

namespace gaitcam {

void StepGate::AddNode() { nodes_.push_back({steps_.position(), steps_.steps()}); }

void StepGate::Visit(int node) {
  Visited& there = nodes_[size_t(node)];
  steps_.SetPosition(there.position);
  there.steps = steps_.steps();
}

bool StepGate::InReach(int node) const {
  const Visited& there = nodes_[size_t(node)];
  const double reach = options_.reach_steps + options_.error * (steps_.steps() - there.steps);
  return !((steps_.position() - there.position).norm() > reach);
}

}  // namespace gaitcam
