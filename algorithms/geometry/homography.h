/// Homographies b ~ H a: two views of a plane, or from one position.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// Normalised direct linear transform over the pairs `use` (Hartley and Zisserman 2003, algorithm 4.2).
/// @returns H scaled to a middle singular value of 1 and points in front of both cameras (b^T H a > 0 for most), or
/// nothing if the pairs do not determine it.
std::optional<Eigen::Matrix3d> EstimateHomography(const std::vector<PointPair>& pairs, const std::vector<int>& use);

/// The same by iteratively reweighted least squares, robust to transfer errors beyond some `threshold`.
std::optional<Eigen::Matrix3d> EstimateHomographyRobustly(const std::vector<PointPair>& pairs,
                                                          const std::vector<int>& use, double threshold);

/// Squared distance of b from where H maps a; infinity behind.
double TransferError2(const Eigen::Matrix3d& H, const PointPair& pair);

/// The motions p_B = R p_A + t that a plane's H = R + t n^T / d allows (Ma, Soatto, Kosecka and Sastry 2004, section
/// 5.3.3): up to four, t in units of the plane's distance d; R alone with t = 0 where H is a rotation.
struct PlaneMotion {
  Eigen::Matrix3d R;
  Eigen::Vector3d t, normal;  ///< The plane lies at normal^T p_A = d > 0.
};
std::vector<PlaneMotion> DecomposeHomography(const Eigen::Matrix3d& H);

}  // namespace gaitcam
