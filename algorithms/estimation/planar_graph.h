/// The planar poses that agree best with measured motions between them: pose-graph least squares.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/planar_pose.h"

namespace gaitcam {

/// A measured motion from one pose to another.
struct PlanarEdge {
  int from = 0, to = 0;
  PlanarPose motion;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< Of x, y (m), yaw (rad), in the frame of `to`.
  bool may_be_wrong = false;  ///< Counts less, the farther it is off (Cauchy): a place may be taken for another.
};

/// Minimises the sum of squared, whitened differences; the first pose stays.
/// @param start to begin from; yaw as it is, whole turns kept. @returns as many poses.
std::vector<PlanarPose> SolvePlanarGraph(const std::vector<PlanarPose>& start, const std::vector<PlanarEdge>& edges);

}  // namespace gaitcam
