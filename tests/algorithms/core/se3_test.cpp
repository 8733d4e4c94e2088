#include "algorithms/core/se3.h"

#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

constexpr double kPi = std::numbers::pi;

template <class T>
using Matrix4 = Eigen::Matrix<T, 4, 4>;

/// The matrix exponential of a twist by its power series: no closed form in common with what is tested.
template <class T>
Matrix4<T> ExpBySeries(const Eigen::Matrix<T, 6, 1>& tau) {
  Matrix4<T> A = Matrix4<T>::Zero();
  A << T(0), -tau[5], tau[4], tau[0], tau[5], T(0), -tau[3], tau[1], -tau[4], tau[3], T(0), tau[2], T(0), T(0), T(0),
      T(0);
  Matrix4<T> term = Matrix4<T>::Identity(), sum = term;
  for (int n = 1; n < 60; ++n) {  // angles to 2 pi: the last term is 6.3^59 / 59! = 1e-33
    term = (term * A / T(n)).eval();
    sum += term;
  }
  return sum;
}

/// (rho, phi) of a 4 x 4 twist.
Vector6d Vee(const Eigen::Matrix4d& A) {
  Vector6d tau;
  tau << A.topRightCorner<3, 1>(), A(2, 1), A(0, 2), A(1, 0);
  return tau;
}

template <int N>
Matrix4<double> Derivative(const Matrix4<ceres::Jet<double, N>>& M, int k) {
  return M.unaryExpr([k](const ceres::Jet<double, N>& jet) { return jet.v[k]; });
}

template <class T>
Eigen::Matrix<T, 6, 1> Variables(const Vector6d& at, int first) {
  Eigen::Matrix<T, 6, 1> tau;
  for (int k = 0; k < 6; ++k) tau[k] = T(at[k], first + k);
  return tau;
}

Vector6d RandomTangent(RandomStream& random, double metres, double rad) {
  Vector6d tau;
  for (int k = 0; k < 6; ++k) tau[k] = random.Normal() * (k < 3 ? metres : rad);
  return tau;
}

/// Rotation vectors where formulas change or lose digits: about zero, about the switch between series and closed form
/// at 1 rad, about a half turn.
std::vector<Vector6d> CriticalTangents() {
  RandomStream random(1, "tangents");
  std::vector<Vector6d> all;
  for (const double angle : {0.0, 1e-200, 1e-12, 1e-8, 1e-5, 0.9e-4, 1.1e-4, 1e-3, 0.03, 0.3, 1 - 1e-9, 1 + 1e-9, 2.0,
                             3.0, kPi - 1e-4, kPi - 1e-8, kPi - 1e-12}) {
    for (int i = 0; i < 5; ++i) {
      Vector6d tau = RandomTangent(random, 1, 1);
      tau.tail<3>() = angle * tau.tail<3>().normalized();
      all.push_back(tau);
    }
  }
  return all;
}

TEST(So3, ExpAndLogAreThoseOfCeres) {
  for (const Vector6d& tau : CriticalTangents()) {
    const Eigen::Vector3d phi = tau.tail<3>();
    double quaternion[4], back[3];  // w x y z
    ceres::AngleAxisToQuaternion(phi.data(), quaternion);
    const Eigen::Quaterniond q = ExpSo3(phi);
    EXPECT_LT((Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()) - Eigen::Map<Eigen::Vector4d>(quaternion)).norm(), 1e-15);
    ceres::QuaternionToAngleAxis(quaternion, back);
    EXPECT_LT((LogSo3(q) - Eigen::Map<Eigen::Vector3d>(back)).norm(), 1e-15 * (1 + phi.norm()));
  }
}

TEST(Se3, LogUndoesExpToRoundingFromNoTurnToAHalfTurn) {
  for (const Vector6d& tau : CriticalTangents()) {
    // A few roundings of numbers of the tangent's size.
    EXPECT_LT((LogSe3(ExpSe3(tau)) - tau).norm(), 2e-15 * (1 + tau.norm())) << tau.transpose();
  }
}

TEST(Se3, SmallTangentsKeepTheirRelativePrecision) {
  RandomStream random(2, "tangents");
  for (const double size : {1e-3, 1e-6, 1e-12, 1e-100}) {
    const Vector6d tau = RandomTangent(random, size, size);
    EXPECT_LT((LogSe3(ExpSe3(tau)) - tau).norm(), 1e-15 * tau.norm());
  }
}

TEST(Se3, BothSignsOfAQuaternionHaveTheSameShortestLog) {
  const Vector6d tau = (Vector6d() << 1, 2, 3, 0.4, -2.5, 1.2).finished();
  Pose X = ExpSe3(tau);
  X.rotation.coeffs() = -X.rotation.coeffs();
  EXPECT_LT((LogSe3(X) - tau).norm(), 1e-14);
  const Eigen::Vector3d beyond = 4.0 * Eigen::Vector3d(0.6, 0, 0.8);  // more than a half turn: back from the other side
  EXPECT_LT((LogSo3(ExpSo3(beyond)) - (1 - 2 * kPi / 4.0) * beyond).norm(), 1e-14);
}

TEST(Se3, ExpIsTheMatrixExponential) {
  for (const Vector6d& tau : CriticalTangents()) {
    // 60 terms of up to pi^3 / 3! = 5 are added: some 1e-15 each.
    EXPECT_LT((ExpSe3(tau).Matrix() - ExpBySeries<double>(tau)).norm(), 2e-14);
  }
}

TEST(So3, JacobiansAreThoseOfAutomaticDifferentiation) {
  using Jet = ceres::Jet<double, 3>;
  for (const Vector6d& tau : CriticalTangents()) {
    const Eigen::Vector3d phi = tau.tail<3>();
    const Jet variables[3] = {Jet(phi.x(), 0), Jet(phi.y(), 1), Jet(phi.z(), 2)};
    Jet R[9];
    ceres::AngleAxisToRotationMatrix(variables, R);  // column major
    Eigen::Matrix3d value, left, right;
    for (int i = 0; i < 9; ++i) value(i % 3, i / 3) = R[i].a;
    for (int k = 0; k < 3; ++k) {
      Eigen::Matrix3d derivative;
      for (int i = 0; i < 9; ++i) derivative(i % 3, i / 3) = R[i].v[k];
      const Eigen::Matrix3d L = derivative * value.transpose(), M = value.transpose() * derivative;
      left.col(k) << L(2, 1), L(0, 2), L(1, 0);
      right.col(k) << M(2, 1), M(0, 2), M(1, 0);
    }
    // Ceres' own formula divides by the angle and, below 1e-8, goes by first order.
    const double tolerance = phi.norm() < 1e-7 ? 1e-8 : 1e-13 + 1e-15 / phi.norm();
    EXPECT_LT((LeftJacobianSo3(phi) - left).norm(), tolerance) << phi.norm();
    EXPECT_LT((RightJacobianSo3(phi) - right).norm(), tolerance) << phi.norm();
  }
}

TEST(Se3, JacobiansAreThoseOfAutomaticDifferentiation) {
  using Jet = ceres::Jet<double, 6>;
  for (const Vector6d& tau : CriticalTangents()) {
    const Matrix4<Jet> M = ExpBySeries<Jet>(Variables<Jet>(tau, 0));
    const Eigen::Matrix4d inverse = ExpSe3(tau).Inverse().Matrix();
    Matrix6d left, right;
    for (int k = 0; k < 6; ++k) {
      left.col(k) = Vee(Derivative(M, k) * inverse);
      right.col(k) = Vee(inverse * Derivative(M, k));
    }
    // Rounding of the series, whose derivatives have terms of up to pi^3 / 2.
    EXPECT_LT((LeftJacobianSe3(tau) - left).norm(), 1e-13) << tau.transpose();
    EXPECT_LT((RightJacobianSe3(tau) - right).norm(), 1e-13) << tau.transpose();
  }
}

TEST(Se3, InverseJacobiansInvert) {
  for (const Vector6d& tau : CriticalTangents()) {
    const Eigen::Vector3d phi = tau.tail<3>();
    EXPECT_LT((LeftJacobianInverseSo3(phi) * LeftJacobianSo3(phi) - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_LT((RightJacobianInverseSo3(phi) * RightJacobianSo3(phi) - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_LT((LeftJacobianInverseSe3(tau) * LeftJacobianSe3(tau) - Matrix6d::Identity()).norm(), 1e-13);
    EXPECT_LT((RightJacobianInverseSe3(tau) * RightJacobianSe3(tau) - Matrix6d::Identity()).norm(), 1e-13);
  }
}

TEST(Se3, AdjointCarriesAPerturbationToTheOtherSide) {
  RandomStream random(3, "poses");
  for (int i = 0; i < 20; ++i) {
    const Pose X = ExpSe3(RandomTangent(random, 2, 1));
    const Vector6d tau = RandomTangent(random, 1, 1);  // exact for perturbations of any size
    const Eigen::Matrix4d right = Plus(X, tau).Matrix(), left = (ExpSe3(Adjoint(X) * tau) * X).Matrix();
    EXPECT_LT((right - left).norm(), 1e-13 * (1 + right.norm()));
  }
}

TEST(Se3, MinusUndoesPlus) {
  RandomStream random(4, "poses");
  const Pose X = ExpSe3(RandomTangent(random, 2, 1));
  const Vector6d tau = RandomTangent(random, 1, 0.5);
  EXPECT_LT((Minus(Plus(X, tau), X) - tau).norm(), 1e-14);
  // Translation first, in the frame that X maps from.
  const Pose forward = Plus(X, (Vector6d() << 0, 0, 1, 0, 0, 0).finished());
  EXPECT_LT((forward.translation - (X.translation + X.R().col(2))).norm(), 1e-15);
}

/// Two poses and the joint covariance of their errors.
struct Joint {
  Pose first, second;
  Eigen::Matrix<double, 12, 12> covariance;

  Matrix6d of_first() const { return covariance.topLeftCorner<6, 6>(); }
  Matrix6d of_second() const { return covariance.bottomRightCorner<6, 6>(); }
  Matrix6d cross() const { return covariance.topRightCorner<6, 6>(); }
};

Joint RandomJoint(uint64_t seed, double sigma) {
  RandomStream random(seed, "joint");
  Joint joint;
  joint.first = ExpSe3(RandomTangent(random, 1, 1));
  joint.second = ExpSe3(RandomTangent(random, 1, 1));
  Eigen::Matrix<double, 12, 12> A;
  for (int i = 0; i < 144; ++i) A(i / 12, i % 12) = sigma * random.Normal();
  joint.covariance = A * A.transpose();
  return joint;
}

using Jet12 = ceres::Jet<double, 12>;

/// J Sigma J' for the error that `combine` of the two perturbed poses has about its value, J by differentiation.
template <class Combine>
Matrix6d Propagated(const Joint& joint, Combine combine) {
  const auto perturbed = [](const Pose& X, int first) -> Matrix4<Jet12> {
    return X.Matrix().cast<Jet12>() * ExpBySeries<Jet12>(Variables<Jet12>(Vector6d::Zero(), first));
  };
  const Matrix4<Jet12> M = combine(perturbed(joint.first, 0), perturbed(joint.second, 6));
  const Eigen::Matrix4d value = M.unaryExpr([](const Jet12& jet) { return jet.a; });
  Eigen::Matrix<double, 6, 12> J;
  for (int k = 0; k < 12; ++k) J.col(k) = Vee(value.inverse() * Derivative(M, k));
  return J * joint.covariance * J.transpose();
}

Matrix4<Jet12> InverseOf(const Matrix4<Jet12>& M) {
  Matrix4<Jet12> inverse = Matrix4<Jet12>::Identity();
  inverse.topLeftCorner<3, 3>() = M.topLeftCorner<3, 3>().transpose();
  inverse.topRightCorner<3, 1>() = -M.topLeftCorner<3, 3>().transpose() * M.topRightCorner<3, 1>();
  return inverse;
}

TEST(Covariance, IsWhatDifferentiationPropagates) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const Joint joint = RandomJoint(seed, 1);
    const auto relative_error = [](const Matrix6d& a, const Matrix6d& b) { return (a - b).norm() / b.norm(); };
    EXPECT_LT(relative_error(CovarianceOfInverse(joint.first, joint.of_first()),
                             Propagated(joint, [](const auto& a, const auto&) { return InverseOf(a); })),
              1e-12);
    EXPECT_LT(relative_error(CovarianceOfProduct(joint.second, joint.of_first(), joint.of_second(), joint.cross()),
                             Propagated(joint, [](const auto& a, const auto& b) { return Matrix4<Jet12>(a * b); })),
              1e-12);
    const Pose X_BC = joint.first.Inverse() * joint.second;
    EXPECT_LT(relative_error(
                  CovarianceOfRelative(X_BC, joint.of_first(), joint.of_second(), joint.cross()),
                  Propagated(joint, [](const auto& a, const auto& b) { return Matrix4<Jet12>(InverseOf(a) * b); })),
              1e-12);
  }
}

/// Of many draws of the two poses, the covariance of the error of what `combine` makes of them, whitened by `stated`:
/// the identity if that is right.
template <class Combine>
Matrix6d WhitenedSampleCovariance(const Joint& joint, int draws, Combine combine, const Matrix6d& stated) {
  RandomStream random(7, "draws");
  const Eigen::Matrix<double, 12, 12> L = joint.covariance.llt().matrixL();
  const Matrix6d whiten = stated.llt().matrixL().toDenseMatrix().inverse();
  const Pose middle = combine(joint.first, joint.second);
  Matrix6d sum = Matrix6d::Zero();
  for (int i = 0; i < draws; ++i) {
    Eigen::Matrix<double, 12, 1> z;
    for (int k = 0; k < 12; ++k) z[k] = random.Normal();
    const Eigen::Matrix<double, 12, 1> tau = L * z;
    const Pose drawn = combine(Plus(joint.first, tau.head<6>()), Plus(joint.second, tau.tail<6>()));
    const Vector6d error = whiten * Minus(drawn, middle);
    sum += error * error.transpose();
  }
  return sum / draws;
}

TEST(Covariance, IsThatOfManyDraws) {
  // An entry of the whitened sample covariance has a standard deviation of sqrt(2 / draws) at most, 0.01; of 21 entries
  // none should be off by five. Errors of 0.003 sqrt(12) make the second order, about their square, 1e-4.
  constexpr int kDraws = 20000;
  constexpr double kTolerance = 0.05;
  const Joint joint = RandomJoint(11, 0.003);
  const auto off = [&](auto combine, const Matrix6d& stated) {
    return (WhitenedSampleCovariance(joint, kDraws, combine, stated) - Matrix6d::Identity()).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(
      off([](const Pose& a, const Pose&) { return a.Inverse(); }, CovarianceOfInverse(joint.first, joint.of_first())),
      kTolerance);
  EXPECT_LT(off([](const Pose& a, const Pose& b) { return a * b; },
                CovarianceOfProduct(joint.second, joint.of_first(), joint.of_second(), joint.cross())),
            kTolerance);
  const Pose X_BC = joint.first.Inverse() * joint.second;
  const auto relative = [](const Pose& a, const Pose& b) { return a.Inverse() * b; };
  EXPECT_LT(off(relative, CovarianceOfRelative(X_BC, joint.of_first(), joint.of_second(), joint.cross())), kTolerance);
  EXPECT_GT(off(relative, CovarianceOfRelative(X_BC, joint.of_first(), joint.of_second())), 4 * kTolerance)
      << "what is left out matters here";
}

TEST(RelativePose, ThereAndBackIsTheIdentityInTimeAndPlace) {
  const Joint joint = RandomJoint(12, 0.1);
  const RelativePose there{10, 20, joint.first, joint.of_first()};
  const RelativePose back = there.Inverse();
  EXPECT_EQ(back.from_ns, 20);
  EXPECT_EQ(back.to_ns, 10);
  EXPECT_LT(LogSe3((there * back).X_FT).norm(), 1e-14);
  EXPECT_LT((back.Inverse().covariance - there.covariance).norm(), 1e-13 * there.covariance.norm());
  const RelativePose next{20, 50, joint.second, joint.of_second()};
  EXPECT_EQ((there * next).to_ns, 50);
  EXPECT_LT(((there * next).covariance - CovarianceOfProduct(joint.second, joint.of_first(), joint.of_second())).norm(),
            1e-15);
}

}  // namespace
}  // namespace gaitcam
