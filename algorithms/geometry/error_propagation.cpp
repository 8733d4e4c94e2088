#include "algorithms/geometry/error_propagation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// Weight of a match in the cost e^T W e.
Eigen::Matrix3d WeightOf(const PointMatch& match, const Pose& X_AB, MotionCost cost) {
  if (cost == MotionCost::kDistances) return Eigen::Matrix3d::Identity();
  return InverseOfSymmetric<3>(MatchError(match, X_AB).covariance);
}

/// d^2 (Exp(tau) p) / d tau_i d tau_j at tau = 0: Exp(tau) p = p + rho + phi x p + (phi x rho + phi x (phi x p)) / 2 +
/// ...
Eigen::Vector3d SecondDerivative(int i, int j, const Eigen::Vector3d& p) {
  if (i > j) std::swap(i, j);
  if (j < 3) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d turn = Eigen::Vector3d::Unit(j - 3);
  if (i < 3) return 0.5 * turn.cross(Eigen::Vector3d::Unit(i));
  const Eigen::Vector3d other = Eigen::Vector3d::Unit(i - 3);
  return 0.5 * (turn.cross(other.cross(p)) + other.cross(turn.cross(p)));
}

/// -e^T W g_ij, `pull` being W e in B's axes.
Matrix6d Bend(const Eigen::Vector3d& pull, const Eigen::Vector3d& p_B) {
  Matrix6d bend;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) bend(i, j) = -pull.dot(SecondDerivative(i, j, p_B));
  return bend;
}

/// With e = p_A - X_AB p_B and g_i = d (X_AB Exp(tau) p_B) / d tau_i, half of Phi is -sum e^T W g_i, of its derivative
/// by tau_j sum g_i^T W g_j - e^T W g_ij, by p_A -g_i^T W, and by p_B g_i^T W R - e^T W dg_i / dp_B.
struct CostDerivatives {
  Matrix6d without_residuals = Matrix6d::Zero(), by_motion = Matrix6d::Zero();
  std::vector<MotionJacobian> by_point;

  CostDerivatives(const std::vector<PointMatch>& matches, const Pose& X_AB, MotionCost cost) {
    const Eigen::Matrix3d R = X_AB.R();
    by_point.reserve(matches.size());
    for (const PointMatch& match : matches) {
      const Eigen::Matrix3d W = WeightOf(match, X_AB, cost);
      Matrix36 g;
      g << R, -R * Hat(match.p_B);
      const Eigen::Vector3d pull = R.transpose() * (W * (match.p_A - X_AB * match.p_B));  // W e in B's axes
      without_residuals += g.transpose() * W * g;
      by_motion += Bend(pull, match.p_B);
      MotionJacobian d_phi{-g.transpose() * W, g.transpose() * W * R};
      d_phi.by_B.bottomRows<3>() -= Hat(pull).transpose();  // e^T W R (e_i x p) by p is (pull x e_i)^T
      by_point.push_back(d_phi);
    }
    by_motion += without_residuals;
  }

  std::vector<MotionJacobian> Jacobians() const {
    const Matrix6d inverse = InverseOfSymmetric<6>(by_motion);
    std::vector<MotionJacobian> jacobians;
    for (const MotionJacobian& d_phi : by_point) jacobians.push_back({-inverse * d_phi.by_A, -inverse * d_phi.by_B});
    return jacobians;
  }
  /// What the residuals' part adds to the NEES, its root, for errors that have the matches' covariances: with a part B
  /// of theirs and the rest G, an error tau of first order becomes tau - G^-1 B tau.
  double ExpectedBending(const std::vector<PointMatch>& matches, const Pose& X_AB, MotionCost cost,
                         const Matrix6d& covariance) const {
    const Matrix6d inverse = InverseOfSymmetric<6>(without_residuals);
    const Matrix6d information = InverseOfSymmetric<6>(covariance);
    const Eigen::Matrix3d R_BA = X_AB.R().transpose();
    double sum = 0;
    for (const PointMatch& match : matches) {
      const Eigen::Matrix3d L = MatchError(match, X_AB).covariance.llt().matrixL();
      const Eigen::Matrix3d pulls = R_BA * WeightOf(match, X_AB, cost) * L;
      for (int c = 0; c < 3; ++c) {
        const Matrix6d ratio = inverse * Bend(pulls.col(c), match.p_B);
        sum += (information * ratio * covariance * ratio.transpose()).trace();
      }
    }
    return std::sqrt(std::max(0.0, sum));
  }
};

}  // namespace

Vector6d EulerOf(const Pose& X) {
  const Eigen::Matrix3d R = X.R();
  Vector6d d;
  d << X.translation, std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
      std::atan2(R(1, 0), R(0, 0));
  return d;
}

Pose PoseOfEuler(const Vector6d& d) { return {RotZ(d[5]) * RotY(d[4]) * RotX(d[3]), d.head<3>()}; }

Matrix6d EulerJacobian(const Pose& X) {
  const Vector6d d = EulerOf(X);
  const double sin_roll = std::sin(d[3]), cos_roll = std::cos(d[3]), cos_pitch = std::cos(d[4]);
  const double tan_pitch = std::tan(d[4]);
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = X.R();
  J.bottomRightCorner<3, 3>() << 1, sin_roll * tan_pitch, cos_roll * tan_pitch,  //
      0, cos_roll, -sin_roll,                                                    //
      0, sin_roll / cos_pitch, cos_roll / cos_pitch;
  return J;
}

std::vector<MotionJacobian> MotionJacobians(const std::vector<PointMatch>& matches, const Pose& X_AB, MotionCost cost) {
  return CostDerivatives(matches, X_AB, cost).Jacobians();
}

Matrix6d CovarianceOfMotion(const std::vector<PointMatch>& matches, const std::vector<MotionJacobian>& jacobians) {
  Matrix6d covariance = Matrix6d::Zero();
  for (size_t k = 0; k < matches.size(); ++k) {
    const MotionJacobian& J = jacobians[k];
    covariance += J.by_A * matches[k].covariance_A * J.by_A.transpose();
    covariance += J.by_B * matches[k].covariance_B * J.by_B.transpose();
  }
  return covariance;
}

PropagatedMotion PropagateMotion(const std::vector<StereoPointMatch>& matches, const Pose& X_AB, MotionCost cost) {
  std::vector<PointMatch> points, second;
  for (const StereoPointMatch& match : matches) {
    points.push_back(match.Match());
    second.push_back({match.A.p_L, match.B.p_L, match.A.covariance_second, match.B.covariance_second});
  }
  const CostDerivatives derivatives(points, X_AB, cost);
  const std::vector<MotionJacobian> jacobians = derivatives.Jacobians();
  PropagatedMotion motion;
  motion.covariance = CovarianceOfMotion(points, jacobians);
  motion.covariance_second = CovarianceOfMotion(second, jacobians);
  motion.bias.setZero();
  double sum = 0;
  for (size_t k = 0; k < matches.size(); ++k) {
    motion.bias += jacobians[k].by_A * matches[k].A.bias + jacobians[k].by_B * matches[k].B.bias;
    sum += (std::pow(matches[k].A.nonlinearity, 2) + std::pow(matches[k].B.nonlinearity, 2)) / 2;
  }
  motion.weight_bias = std::sqrt(sum);
  const Matrix6d second_order = motion.covariance_second + motion.bias * motion.bias.transpose();
  motion.nonlinearity = std::sqrt(std::max(0.0, (InverseOfSymmetric<6>(motion.covariance) * second_order).trace()));
  motion.bending = derivatives.ExpectedBending(points, X_AB, cost, motion.covariance);
  // Limits from the map of `gaitcam experiment nees`.
  constexpr double kNonlinearity = 0.5, kBending = 0.7, kWeightBias = 0.4;
  motion.first_order_holds = motion.nonlinearity < kNonlinearity && motion.bending < kBending &&
                             (cost == MotionCost::kDistances || motion.weight_bias < kWeightBias);
  return motion;
}

}  // namespace gaitcam
