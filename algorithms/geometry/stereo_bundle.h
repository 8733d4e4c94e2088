/// Bundle adjustment of a stereo rig: its poses, the points that it sees, and how the right camera stands to the left
/// one, each image point weighted by a covariance of its own. With the covariance of what was estimated.
///
/// Normal equations with the points eliminated, as in bundle_adjustment.h. Lengths are metres: the baseline sets them.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/se3.h"

namespace gaitcam {

struct StereoBundleCamera {
  Pose X_WC;           ///< Of the left camera. Initial value; refined unless fixed.
  bool fixed = false;  ///< At least one should be: else nothing but damping holds the world.
};

struct StereoBundleObservation {
  int camera = 0;
  int point = 0;
  bool right = false;                                        ///< By the right camera.
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();              ///< Normalised coordinates, distortion undone.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< Of xy; positive definite.
};

struct StereoBundleProblem {
  Pose X_LR;  ///< Maps points of the right camera into the left one. Initial value; refined as its prior permits.
  Pose prior_X_LR;
  Matrix6d prior_covariance = Matrix6d::Zero();  ///< Of prior_X_LR, positive definite; all zero: X_LR is fixed.
  std::vector<StereoBundleCamera> cameras;
  std::vector<Eigen::Vector3d> points;  ///< p_W. Initial values; refined. Each has two observations at least.
  std::vector<StereoBundleObservation> observations;
};

struct StereoBundleOptions {
  int max_iterations = 8;
  double huber = 2.0;  ///< Threshold of Huber's loss, in standard deviations.
};

struct StereoBundleResult {
  double cost_before = 0, cost_after = 0;  ///< Half the sum of robust squared residuals, the prior included.
  bool has_covariance = false;             ///< False: singular.
  /// Of each camera's tangent, relative to the fixed ones; zero for those. All else is marginalised.
  std::vector<Matrix6d> camera_covariances;
  /// Of each camera's tangent, those of the fixed ones too, by its own images of points that another camera sees, the
  /// points taken as exact. Zero where these determine no pose.
  std::vector<Matrix6d> own_covariances;
  /// Of each p_W, the cameras held fixed. Singular: its images leave the point open.
  std::vector<Eigen::Matrix3d> point_covariances;
  Matrix6d rig_covariance = Matrix6d::Zero();  ///< Of X_LR; zero if fixed.
  std::vector<double> errors2;                 ///< Squared Mahalanobis length of each observation's residual.
};

/// Refines the problem in place. Deterministic.
StereoBundleResult AdjustStereoBundle(StereoBundleProblem& problem, const StereoBundleOptions& options);

}  // namespace gaitcam
