/// Pose graph of planar poses: least squares over measured relative poses.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/planar_pose.h"

namespace gaitcam {

/// A measured relative pose.
struct PlanarEdge {
  int from = 0, to = 0;
  PlanarPose motion;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< Of x, y (m), yaw (rad), in the frame of `to`.
  bool may_be_wrong = false;  ///< Of a loop closure: Cauchy's robust loss, against false ones.
};

/// Minimises the sum of squared whitened residuals; the first pose is held.
/// @param start initial values; headings need not be wrapped, full turns are kept. @returns as many poses.
std::vector<PlanarPose> SolvePlanarGraph(const std::vector<PlanarPose>& start, const std::vector<PlanarEdge>& edges);

/// Of each pose relative to the first one, in its own frame, at the solution of the same graph: marginals of the least
/// squares problem, loop closures taken as true.
/// @pre every pose is connected with the first one.
std::vector<Eigen::Matrix3d> PlanarGraphCovariances(const std::vector<PlanarPose>& solved,
                                                    const std::vector<PlanarEdge>& edges);

}  // namespace gaitcam
