#include "algorithms/core/se3.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Stumpff's functions c_n(x) = sum over k of (-x)^k / (2 k + n)! at x = angle^2, n = 1 to 5. The coefficients of all
/// Jacobians are made of them, without the differences of nearly equal numbers that their closed forms have at small
/// angles: c_1 = sin(a) / a, c_2 = (1 - cos a) / a^2, c_3 = (a - sin a) / a^3, and so on.
struct Stumpff {
  double c1, c2, c3, c4, c5;

  explicit Stumpff(double angle) {
    const double x = angle * angle;
    if (x < 1) {
      c4 = Sum(x, 24, 4);
      c5 = Sum(x, 120, 5);
      c2 = 1.0 / 2 - x * c4;
      c3 = 1.0 / 6 - x * c5;
      c1 = 1 - x * c3;
    } else {
      c1 = std::sin(angle) / angle;
      c2 = (1 - std::cos(angle)) / x;
      c3 = (1 - c1) / x;
      c4 = (1.0 / 2 - c2) / x;
      c5 = (1.0 / 6 - c3) / x;
    }
  }

  static double Sum(double x, double factorial, int n) {
    double term = 1 / factorial, sum = term;
    for (int k = n + 1; std::abs(term) > std::numeric_limits<double>::epsilon() * sum; k += 2) {
      term *= -x / (k * (k + 1));
      sum += term;
    }
    return sum;
  }

  /// (1 - angle / 2 cot(angle / 2)) / angle^2, the coefficient of Hat^2 in the inverse Jacobians of SO(3).
  double Inverse() const { return (c3 - 2 * c4) / (2 * c2); }
};

/// Eq. 180.
Eigen::Matrix3d LeftJacobianCorner(const Vector6d& tau, const Stumpff& c) {
  const Eigen::Matrix3d P = Hat(tau.head<3>()), W = Hat(tau.tail<3>());
  const Eigen::Matrix3d WP = W * P, PW = P * W, WPW = WP * W;
  return 0.5 * P + c.c3 * (WP + PW + WPW) + c.c4 * (W * WP + PW * W - 3 * WPW) +
         0.5 * (c.c4 - 3 * c.c5) * (WPW * W + W * WPW);
}

Matrix6d BlockTriangular(const Eigen::Matrix3d& diagonal, const Eigen::Matrix3d& corner) {
  Matrix6d J;
  J << diagonal, corner, Eigen::Matrix3d::Zero(), diagonal;
  return J;
}

}  // namespace

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, phi / angle));
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q);  // by atan2(|vec|, |w|): accurate at all angles
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d LeftJacobianSo3(const Eigen::Vector3d& phi) {
  const Stumpff c(phi.norm());
  const Eigen::Matrix3d W = Hat(phi);
  return Eigen::Matrix3d::Identity() + c.c2 * W + c.c3 * W * W;
}

Eigen::Matrix3d LeftJacobianInverseSo3(const Eigen::Vector3d& phi) {
  const Stumpff c(phi.norm());
  const Eigen::Matrix3d W = Hat(phi);
  return Eigen::Matrix3d::Identity() - 0.5 * W + c.Inverse() * W * W;
}

Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& phi) { return LeftJacobianSo3(-phi); }
Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& phi) { return LeftJacobianInverseSo3(-phi); }

Pose ExpSe3(const Vector6d& tau) {
  const Eigen::Vector3d phi = tau.tail<3>();
  return {ExpSo3(phi), LeftJacobianSo3(phi) * tau.head<3>()};
}

Vector6d LogSe3(const Pose& X) {
  const Eigen::Vector3d phi = LogSo3(X.rotation);
  Vector6d tau;
  tau << LeftJacobianInverseSo3(phi) * X.translation, phi;
  return tau;
}

Pose Plus(const Pose& X, const Vector6d& tau) { return X * ExpSe3(tau); }
Vector6d Minus(const Pose& Y, const Pose& X) { return LogSe3(X.Inverse() * Y); }

Matrix6d Adjoint(const Pose& X) { return BlockTriangular(X.R(), Hat(X.translation) * X.R()); }

Matrix6d LeftJacobianSe3(const Vector6d& tau) {
  const Eigen::Vector3d phi = tau.tail<3>();
  return BlockTriangular(LeftJacobianSo3(phi), LeftJacobianCorner(tau, Stumpff(phi.norm())));
}

Matrix6d LeftJacobianInverseSe3(const Vector6d& tau) {
  const Eigen::Vector3d phi = tau.tail<3>();
  const Eigen::Matrix3d inverse = LeftJacobianInverseSo3(phi);
  return BlockTriangular(inverse, -inverse * LeftJacobianCorner(tau, Stumpff(phi.norm())) * inverse);
}

Matrix6d RightJacobianSe3(const Vector6d& tau) { return LeftJacobianSe3(-tau); }
Matrix6d RightJacobianInverseSe3(const Vector6d& tau) { return LeftJacobianInverseSe3(-tau); }

// (X Exp(tau))^-1 = Exp(-tau) X^-1 = X^-1 Exp(-Ad_X tau), whose sign a covariance does not see.
Matrix6d CovarianceOfInverse(const Pose& X_AB, const Matrix6d& covariance_AB) {
  const Matrix6d J = Adjoint(X_AB);
  return J * covariance_AB * J.transpose();
}

// X_AB Exp(a) X_BC Exp(c) = X_AC Exp(Ad_CB a) Exp(c).
Matrix6d CovarianceOfProduct(const Pose& X_BC, const Matrix6d& covariance_AB, const Matrix6d& covariance_BC,
                             const Matrix6d& cross) {
  const Matrix6d J = Adjoint(X_BC.Inverse()), mixed = J * cross;
  return J * covariance_AB * J.transpose() + covariance_BC + mixed + mixed.transpose();
}

// (X_AB Exp(b))^-1 X_AC Exp(c) = X_BC Exp(-Ad_CB b) Exp(c).
Matrix6d CovarianceOfRelative(const Pose& X_BC, const Matrix6d& covariance_AB, const Matrix6d& covariance_AC,
                              const Matrix6d& cross) {
  return CovarianceOfProduct(X_BC, covariance_AB, covariance_AC, -cross);
}

Matrix6d CarryCovariance(const Matrix6d& covariance_WA, const Pose& X_AB) {
  const Matrix6d adjoint = Adjoint(X_AB.Inverse());
  return adjoint * covariance_WA * adjoint.transpose();
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().maxCoeff());
}

RelativePose RelativePose::Inverse() const {
  return {to_ns, from_ns, X_FT.Inverse(), CovarianceOfInverse(X_FT, covariance)};
}

RelativePose operator*(const RelativePose& first, const RelativePose& second) {
  GAITCAM_ASSERT(first.to_ns == second.from_ns);
  return {first.from_ns, second.to_ns, first.X_FT * second.X_FT,
          CovarianceOfProduct(second.X_FT, first.covariance, second.covariance)};
}

}  // namespace gaitcam
