/// The motion between two pairs of a stereo rig that makes their pixels most likely.
///
/// Beyond Valencia, who aligns reconstructed points (section 2.2). Weights that are made from measured points favour
/// those that happen to look near, and what this does to the motion does not average out over points; here points are
/// unknowns beside the motion, and covariances are those of pixels, which do not depend on any measurement.

#pragma once

#include <vector>

#include "algorithms/geometry/rigid_motion.h"
#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// Least squares of the eight pixel coordinates of each point over their covariances, by Gauss-Newton over X_AB and the
/// points, the latter eliminated (R. Hartley and A. Zisserman, Multiple View Geometry, 2003, section A6.3).
/// @param A, B the same points seen before and after, of equal number; outliers do harm
/// @param X_AB where to start, as FitRigidMotion gives it
/// @returns the motion, its covariance as of RefineRigidMotion, and the cost: chi-square of 5 n - 6 degrees of freedom.
/// The covariance is NaN if fewer than three points have rays or the problem is singular.
LikelyMotion RefineStereoMotion(const StereoRig& rig, const std::vector<StereoSighting>& A,
                                const std::vector<StereoSighting>& B, const Pose& X_AB);

}  // namespace gaitcam
