/// What errors of pixels make of a motion: pixels -> points -> relative pose, in closed form.
///
/// Source: Valencia, section 2.3. A pose that minimises a cost depends on the points through Phi = dC/dd = 0, and the
/// implicit function theorem gives its derivative without a formula for the pose itself (Eqs. 2.22, 2.23). The first
/// step, pixels -> point, is in stereo_reconstruction.h.
///
/// At a minimum the derivative does not depend on how poses are parametrised, up to the parameters' own Jacobian: it is
/// computed once, in the tangent of se3.h, and EulerJacobian() carries it to the chapter's d = (x, y, z, roll, pitch,
/// yaw).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/se3.h"
#include "algorithms/geometry/rigid_motion.h"
#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// The chapter's d: translation in m, then roll, pitch and yaw in rad with R = RotZ(yaw) RotY(pitch) RotX(roll), pitch
/// in [-pi/2, pi/2]. (Which Euler angles its rot() takes is not said.)
Vector6d EulerOf(const Pose& X);
Pose PoseOfEuler(const Vector6d& d);
/// d EulerOf(X Exp(tau)) / d tau at tau = 0. It grows beyond all bounds at a pitch of +-pi/2.
Matrix6d EulerJacobian(const Pose& X);

/// The two costs whose minimum a motion may be.
enum class MotionCost {
  kDistances,          ///< Eq. 2.28: squared distances.
  kMaximumLikelihood,  ///< MatchError::Squared() with covariances as they are at the motion.
};

/// d tau / d p_A and d tau / d p_B of one match: by how much X_AB Exp(tau) follows the point (Eq. 2.29), rad/m and m/m.
struct MotionJacobian {
  Eigen::Matrix<double, 6, 3> by_A, by_B;
};

/// Eq. 2.29 with the residuals' second derivatives, of all matches at the minimum X_AB; weights of the likelihood are
/// taken as constants.
/// @pre Degeneracy(matches) is kOk.
std::vector<MotionJacobian> MotionJacobians(const std::vector<PointMatch>& matches, const Pose& X_AB, MotionCost cost);

/// Eqs. 2.30 and 2.31: errors of different points, and of the same in A and B, are independent.
Matrix6d CovarianceOfMotion(const std::vector<PointMatch>& matches, const std::vector<MotionJacobian>& jacobians);

/// A point seen by the rig before (B's frame: where it was) and after.
struct StereoPointMatch {
  StereoPoint A, B;

  PointMatch Match() const { return {A.p_L, B.p_L, A.covariance, B.covariance}; }
};

/// How far a motion is to be believed. All in the tangent of X_AB.
struct PropagatedMotion {
  Matrix6d covariance;         ///< Of first order (Eq. 2.30).
  Vector6d bias;               ///< Of second order: mean error of the motion from the points' own bias.
  Matrix6d covariance_second;  ///< What the points' terms of second order add to the covariance.
  double nonlinearity = 0;     ///< What these two add to the NEES, its root.
  /// What the bending of the cost by residuals adds to the NEES, its root, expected for errors of the points'
  /// covariances: large where points err as much as the cloud extends, or where a direction of the motion is known much
  /// better than another.
  double bending = 0;
  /// Root of the sum over points of their squared nonlinearity. Weights that are made from measured points pull the
  /// motion by a square of each point's relative error, all in one direction.
  double weight_bias = 0;
  /// The covariance says what it should, to a sixth in NEES: what of the above matters to this cost is small.
  bool first_order_holds = false;
};

/// @pre all points are kOk, and MotionJacobians'.
PropagatedMotion PropagateMotion(const std::vector<StereoPointMatch>& matches, const Pose& X_AB, MotionCost cost);

}  // namespace gaitcam
