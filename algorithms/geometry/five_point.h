/// Relative pose from the fewest points: five (D. Nister, "An efficient solution to the five-point relative pose
/// problem", PAMI 26(6), 2004).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

/// Up to ten essential matrices E, |E| = sqrt(2), with b^T E a = 0 for the five pairs. Planes are no special case.
/// @returns nothing where the five pairs do not determine finitely many (equal pairs, for example). Never NaN.
std::vector<Eigen::Matrix3d> SolveFivePoint(const std::vector<PointPair>& five);

}  // namespace gaitcam
