/// A pose graph: poses of a camera, and relative motions that were measured between them.

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/se3.h"

namespace gaitcam {

struct GraphNode {
  int64_t stamp_ns = 0;
  Pose X_WC;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of X_WC; the first pose is exact, being the world.
};

/// A measured motion X_FT, `from` (F) to `to` (T).
struct GraphLink {
  int from = 0, to = 0;  ///< Nodes.
  Pose X_FT;
  Matrix6d covariance = Matrix6d::Identity();  ///< Of X_FT.
  bool loop = false;                           ///< A loop closure: another place may have been mistaken for this one.
  double trust = 1;                            ///< Share of its information that was used; near 0 it was found false.
  bool dead_reckoned = false;                  ///< By the body's odometry alone: the camera measured nothing.
};

struct PoseGraph {
  std::vector<GraphNode> nodes;
  std::vector<GraphLink> links;
  int candidates = 0;  ///< Poses that were there to be kept as nodes.
};

}  // namespace gaitcam
