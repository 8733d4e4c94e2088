/// Relative motions from essential matrices.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/se3.h"
#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// p_B = R p_A + t with |t| = 1: the pose X_BA; E = [t]x R.
struct RelativeMotion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d E() const { return Hat(t) * R; }
};

/// Depths (z_A, z_B) of the point nearest to both rays: z_B b = z_A R a + t in least squares; (-1, -1) for parallel
/// rays.
Eigen::Vector2d Depths(const RelativeMotion& motion, const PointPair& pair);

/// The point lies in front of both cameras.
bool InFront(const RelativeMotion& motion, const PointPair& pair);

/// The four motions of an essential matrix (Hartley and Zisserman 2003, result 9.19).
std::vector<RelativeMotion> DecomposeEssential(const Eigen::Matrix3d& E);

/// The decomposition with the largest number of pairs `use` in front of both cameras (thesis 5.4, step 5).
RelativeMotion ChooseByDepth(const Eigen::Matrix3d& E, const std::vector<PointPair>& pairs,
                             const std::vector<int>& use);

/// The rotation that alone brings the rays a nearest to the rays b (Arun, Huang and Blostein, PAMI 1987), robust to
/// errors beyond some `threshold` (radians, nearly pixels / focal length).
Eigen::Matrix3d RotationAlone(const std::vector<PointPair>& pairs, const std::vector<int>& use, double threshold);

}  // namespace gaitcam
