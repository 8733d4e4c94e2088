/// The relative pose of two calibrated cameras from point pairs, up to the length of the translation.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {

/// One point in two images, in normalised coordinates (undistorted, focal length 1).
struct PointPair {
  Eigen::Vector2d a, b;
};

/// Up to ten essential matrices E with b^T E a = 0 for the five pairs (Nister, PAMI 2004; OpenCV's implementation).
std::vector<Eigen::Matrix3d> SolveFivePoint(const std::vector<PointPair>& five);

/// First-order geometric error of a pair: its distance from the nearest pair that satisfies the epipolar constraint
/// (Sampson; Hartley and Zisserman 2003, equation 11.9), squared.
double SampsonError2(const Eigen::Matrix3d& E, const PointPair& pair);

struct TwoView {
  Pose X_AB;                      ///< Maps points of camera B into camera A; |translation| = 1.
  std::vector<int> inliers;       ///< Pairs that agree with the pose and lie in front of both cameras, increasing.
  double parallax = 0;            ///< Median over the inliers of the angle between the two rays, rad. Near zero: the
                                  ///< camera only turned, and the translation means nothing.
  double direction_sigma = M_PI;  ///< Standard deviation of the translation's direction, rad, along its worst axis: of
                                  ///< first order, from the inliers' residuals. Small motions leave it large.
};

/// Five-point RANSAC, choice among the four decompositions by depths in front, Gauss-Newton on the Sampson errors.
/// @param options threshold in normalised coordinates (pixels / focal length)
/// @returns no inliers if there are fewer than 8 pairs or nothing was agreed upon. Never NaN.
TwoView EstimateTwoView(const std::vector<PointPair>& pairs, const RansacOptions& options, RandomStream& random);

}  // namespace gaitcam
