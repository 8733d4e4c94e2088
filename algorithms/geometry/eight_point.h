/// Relative pose from eight or more pairs by linear least squares (Hartley, "In defense of the eight-point algorithm",
/// PAMI 19(6), 1997). Fails on planes: there a whole family of matrices fits.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// The moved and scaled coordinates that make linear least squares well conditioned: centroid 0, mean distance sqrt 2.
/// @returns T with (x', y', 1) = T (x, y, 1).
Eigen::Matrix3d NormalisingTransform(const std::vector<Eigen::Vector2d>& points);

/// The essential matrix, |E| = sqrt(2), nearest to the one that minimises the sum of (b^T E a)^2 in normalised
/// coordinates.
/// @returns nothing for fewer than eight pairs or pairs that are all equal.
std::optional<Eigen::Matrix3d> SolveEightPoint(const std::vector<PointPair>& pairs);

}  // namespace gaitcam
