/// The relative pose of two calibrated cameras from point pairs, up to the length of the translation.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/geometry/epipolar.h"
#include "algorithms/geometry/five_point.h"
#include "algorithms/geometry/ransac.h"
#include "algorithms/geometry/relative_motion.h"

namespace gaitcam {

struct TwoView {
  Pose X_AB;                        ///< Maps points of camera B into camera A; |translation| = 1.
  std::vector<int> inliers;         ///< Pairs that agree with the pose and lie in front of both cameras, increasing;
                                    ///< of a rotation: that agree with it.
  double parallax = 0;              ///< Median over the inliers of the angle between the two rays, rad. Near zero: a
                                    ///< rotation only, and the translation is not observable.
  double direction_sigma = M_PI;    ///< Standard deviation of the translation's direction, rad, along its worst axis:
                                    ///< of first order, from the inliers' residuals. Large for small motions.
  bool rotation_only = false;       ///< GRIC prefers a rotation alone: X_AB holds it, with an arbitrary direction.
  bool planar = false;              ///< GRIC prefers a plane's homography.
  std::optional<Pose> alternative;  ///< Another pose, in another direction, that explains the pairs about as well: two
                                    ///< views of a plane allow two, and small motions may have several.
};

/// Five-point hypotheses judged as `options.estimator` says, choice among the four decompositions by depths in front,
/// Gauss-Newton on the Sampson errors from several starts (among them what a homography allows: planes are no special
/// case), and model selection by Torr's GRIC (IJCV 50, 2002).
/// @param options threshold in normalised coordinates (pixels / focal length)
/// @returns no inliers if there are fewer than 8 pairs or no model with 8 inliers. Never NaN.
TwoView EstimateTwoView(const std::vector<PointPair>& pairs, const RansacOptions& options, RandomStream& random);

/// Robust estimate of the essential matrix alone (thesis 5.4, steps 3 and 4).
/// @param error2 squared error of a pair: SampsonError2 or EpipolarDistance2
RansacResult<Eigen::Matrix3d> EstimateEssential(const std::vector<PointPair>& pairs, const RansacOptions& options,
                                                RandomStream& random,
                                                double (*error2)(const Eigen::Matrix3d&, const PointPair&));

/// Inliers, parallax and standard deviation of a given motion, without refinement or model selection.
TwoView DescribeTwoView(const std::vector<PointPair>& pairs, const RelativeMotion& motion, double threshold);

/// EstimateTwoView from a given essential matrix and its inliers.
/// @param up_A unit vector against gravity in camera A, if known: a plane that it makes a floor settles which of the
/// two motions that a plane allows is the true one
TwoView RefineTwoView(const std::vector<PointPair>& pairs, const Eigen::Matrix3d& E, const std::vector<int>& inliers,
                      double threshold, const std::optional<Eigen::Vector3d>& up_A = {});

}  // namespace gaitcam
