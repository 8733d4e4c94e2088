/// The pose of a stereo rig from points that are known up to a covariance, by maximum likelihood, and what the pose's
/// error is made of.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"

namespace gaitcam {

/// A point known up to a covariance, and its images. Normalised coordinates, distortion undone; covariances of each are
/// positive definite, and their errors independent.
struct RigSighting {
  Eigen::Vector3d p_W;
  Eigen::Matrix3d covariance_W;
  Eigen::Vector2d left;
  Eigen::Matrix2d covariance_left;
  bool has_right = false;
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_right = Eigen::Matrix2d::Identity();
};

/// What is known of a pose before: a prediction, so wide that it decides nothing where images say anything.
struct RigPosePrior {
  Pose X_WC;
  double sigma_m = 0, sigma_rad = 0;  ///< Standard deviations per axis, > 0.

  /// Its deviation from the prediction, in standard deviations.
  Vector6d Deviation(const Pose& X) const {
    Vector6d tau = Minus(X, X_WC);
    tau.head<3>() /= sigma_m;
    tau.tail<3>() /= sigma_rad;
    return tau;
  }
};

/// What of a sighting a pose rests on.
enum class SightingUse { kNone, kLeft, kBoth };

struct RigPoseOptions {
  double outlier_sigmas = 3.5;  ///< Largest Mahalanobis distance of an inlier, as of a Gaussian of one dimension.
  double huber = 2.0;           ///< Huber's threshold, likewise.
  int rounds = 4;               ///< Of choosing inliers and refining over them.
  double ransac_sigmas = 4.0;   ///< Threshold of a hypothesis's inliers, of the left image's residual.
  int ransac_samples = 200;
  double cell = 0.12;  ///< Side of the parts of the left image whose residuals hang together, normalised coordinates.
};

struct RigPoseResult {
  Pose X_WC;
  int inliers = 0;
  std::vector<SightingUse> use;                ///< Of each sighting.
  Matrix6d covariance = Matrix6d::Zero();      ///< Of X_WC, all errors taken together.
  Matrix6d covariance_own = Matrix6d::Zero();  ///< The part of the images' errors: what no other frame shares.
  /// Of X_WC, by the residuals themselves instead of what was said of them: those near each other in the image hang
  /// together, those of different parts of it do not (the "sandwich" with clusters: K.-Y. Liang and S. Zeger, 1986).
  /// Points' errors are in it, too, as far as they show.
  Matrix6d covariance_by_residuals = Matrix6d::Zero();
  /// How the pose's tangent moves with each point: d tau / d p_W; zero for those that are not used. With the points'
  /// covariances these make the rest of `covariance`.
  std::vector<Eigen::Matrix<double, 6, 3>> by_point;
  double mean_error2 = 0;  ///< Squared Mahalanobis length of the inliers' residuals, per dimension.
};

/// Refines a pose over the sightings that agree with it, and the prior.
/// @param X_LR maps points of the right camera into the left one.
/// @returns nothing if fewer than `min_inliers` agree, or the pose is not determined. Never NaN.
std::optional<RigPoseResult> RefineRigPose(const std::vector<RigSighting>& sightings, const Pose& X_LR,
                                           const Pose& guess, const RigPosePrior& prior, int min_inliers,
                                           const RigPoseOptions& options);

/// The hypothesis of three points each (RANSAC on the left images, the prior's being judged first) that most agree
/// with, refined. Hypotheses beyond four standard deviations of the prior are none.
std::optional<RigPoseResult> EstimateRigPose(const std::vector<RigSighting>& sightings, const Pose& X_LR,
                                             const RigPosePrior& prior, int min_inliers, const RigPoseOptions& options,
                                             RandomStream& random);

}  // namespace gaitcam
