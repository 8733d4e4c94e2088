/// Relative pose from eight or more pairs by linear least squares (Hartley, "In defense of the eight-point algorithm",
/// PAMI 19(6), 1997). Degenerate for points of a plane.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// Coordinates of centroid 0 and mean distance sqrt 2, for which linear least squares is well conditioned.
/// @returns T with (x', y', 1) = T (x, y, 1).
Eigen::Matrix3d NormalisingTransform(const std::vector<Eigen::Vector2d>& points);

/// The essential matrix, |E| = sqrt(2), nearest to the one that minimises the sum of (b^T E a)^2 in normalised
/// coordinates.
/// @returns nothing for fewer than eight pairs or pairs that are all equal.
std::optional<Eigen::Matrix3d> SolveEightPoint(const std::vector<PointPair>& pairs);

}  // namespace gaitcam
