/// Relative pose from a minimal sample of five points (D. Nister, "An efficient solution to the five-point relative
/// pose problem", PAMI 26(6), 2004).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// Up to ten essential matrices E, |E| = sqrt(2), with b^T E a = 0 for the five pairs. Not degenerate for planes.
/// @returns nothing if the pairs are degenerate (equal pairs, for example). Never NaN.
std::vector<Eigen::Matrix3d> SolveFivePoint(const std::vector<PointPair>& five);

}  // namespace gaitcam
