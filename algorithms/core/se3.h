/// Rigid motions SE(3) and rotations SO(3) as Lie groups: exponential, logarithm, adjoint, Jacobians, covariances.
///
/// Source: J. Sola, J. Deray and D. Atchuthan, "A micro Lie theory for state estimation in robotics", arXiv:1812.01537,
/// 2018; equations below are of that paper. One tangent for the whole project: perturbations act on the right,
/// translation first,
///
///   X + tau = X Exp(tau),   tau = (rho, phi),   rho in m, phi in rad, both in the frame that X maps from,
///
/// and a covariance of X_AB is that of tau in X_AB Exp(tau), hence given in B (m^2, m rad, rad^2). All covariance
/// functions below are of first order in tau.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "algorithms/core/pose.h"

namespace gaitcam {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
/// Columns of tangents, one per error.
using CommonErrors = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// [v]x: Hat(v) u = v x u.
inline Eigen::Matrix3d Hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Rotation by |phi| rad about phi (Eq. 132, as a unit quaternion).
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& phi);
/// The shortest rotation vector, |phi| <= pi. Of a half turn, one of the two.
/// @param q unit quaternion; q and -q give the same.
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q);

/// Exp(phi + d) = Exp(J_l d) Exp(phi) = Exp(phi) Exp(J_r d) to first order in d (Eqs. 143 to 146). The inverses exist
/// for |phi| < 2 pi.
Eigen::Matrix3d LeftJacobianSo3(const Eigen::Vector3d& phi);
Eigen::Matrix3d LeftJacobianInverseSo3(const Eigen::Vector3d& phi);
Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& phi);
Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& phi);

/// Eq. 172.
Pose ExpSe3(const Vector6d& tau);
/// Eq. 173, with the shortest rotation vector.
Vector6d LogSe3(const Pose& X);

/// X Exp(tau).
Pose Plus(const Pose& X, const Vector6d& tau);
/// The tau for which X Exp(tau) = Y.
Vector6d Minus(const Pose& Y, const Pose& X);

/// Ad_X: X Exp(tau) = Exp(Ad_X tau) X (Eq. 175).
Matrix6d Adjoint(const Pose& X);

/// As for SO(3) (Eqs. 179 to 182).
Matrix6d LeftJacobianSe3(const Vector6d& tau);
Matrix6d LeftJacobianInverseSe3(const Vector6d& tau);
Matrix6d RightJacobianSe3(const Vector6d& tau);
Matrix6d RightJacobianInverseSe3(const Vector6d& tau);

/// Of X_BA = X_AB^-1, given that of X_AB.
Matrix6d CovarianceOfInverse(const Pose& X_AB, const Matrix6d& covariance_AB);

/// Of X_AC = X_AB X_BC.
/// @param cross E[tau_AB tau_BC'] of the two factors' errors; zero where they are independent.
Matrix6d CovarianceOfProduct(const Pose& X_BC, const Matrix6d& covariance_AB, const Matrix6d& covariance_BC,
                             const Matrix6d& cross = Matrix6d::Zero());

/// Of X_BC = X_AB^-1 X_AC, for two poses in a common frame A.
/// @param cross E[tau_AB tau_AC'] of the two poses' errors; zero where they are independent. Poses of one trajectory
///              rarely are: what they have in common cancels in X_BC.
Matrix6d CovarianceOfRelative(const Pose& X_BC, const Matrix6d& covariance_AB, const Matrix6d& covariance_AC,
                              const Matrix6d& cross = Matrix6d::Zero());

/// Of X_WA, as one of X_WB where B stands rigidly to A: the same error, in the tangent of B.
Matrix6d CarryCovariance(const Matrix6d& covariance_WA, const Pose& X_AB);

/// Standard deviation in the direction that is known least, of a position or a rotation, in the covariance's units.
double LargestSigma(const Eigen::Matrix3d& covariance);

/// How a body moved from one instant to another: X_FT maps its frame at `to_ns` (T) into that at `from_ns` (F).
struct RelativePose {
  int64_t from_ns = 0, to_ns = 0;
  Pose X_FT;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of X_FT.

  RelativePose Inverse() const;
};

/// Both motions in turn, their errors taken as independent.
/// @pre the second begins when the first ends.
RelativePose operator*(const RelativePose& first, const RelativePose& second);

}  // namespace gaitcam
