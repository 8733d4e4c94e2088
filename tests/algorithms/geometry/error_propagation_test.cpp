#include "algorithms/geometry/error_propagation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "algorithms/core/random.h"
#include "tests/algorithms/geometry/implicit_jacobian.h"
#include "tests/algorithms/geometry/stereo_rigs.h"

namespace gaitcam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kPoints = 4;

/// Eq. 2.28 written down for jets of jets: coordinates of p_A and p_B of each match, then d.
struct DistancesInEuler {
  template <class T>
  T operator()(const std::array<T, 6 * kPoints + 6>& x) const {
    using std::cos;
    using std::sin;
    const T* d = &x[6 * kPoints];
    const T cr = cos(d[3]), sr = sin(d[3]), cp = cos(d[4]), sp = sin(d[4]), cy = cos(d[5]), sy = sin(d[5]);
    const T R[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                       {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                       {-sp, cp * sr, cp * cr}};
    T sum = Number<T>(0);
    for (int k = 0; k < kPoints; ++k) {
      const T *a = &x[size_t(6 * k)], *b = a + 3;
      for (int i = 0; i < 3; ++i) {
        const T e = a[i] - (R[i][0] * b[0] + R[i][1] * b[1] + R[i][2] * b[2] + d[i]);
        sum += e * e;
      }
    }
    return sum;
  }
};

std::vector<PointMatch> NoisyMatches(const Pose& X_AB, double sigma_m, RandomStream& random) {
  const auto draw = [&] { return Vector3d(random.Normal(), random.Normal(), random.Normal()); };
  std::vector<PointMatch> matches;
  for (int k = 0; k < kPoints; ++k) {
    const Vector3d p_B = draw() + Vector3d(0, 0, 4);
    const auto covariance = [&] {
      Matrix3d A;
      A << draw(), draw(), draw();
      return Matrix3d(A * A.transpose());
    };
    matches.push_back({X_AB * p_B + sigma_m * draw(), p_B + sigma_m * draw(), covariance(), covariance()});
  }
  return matches;
}

TEST(ErrorPropagation, EulerAnglesAndTheirJacobian) {
  RandomStream random(1, "euler");
  for (int trial = 0; trial < 100; ++trial) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = random.Uniform(-1.4, 1.4);
    const Pose X = PoseOfEuler(d);
    EXPECT_LT((EulerOf(X) - d).norm(), 1e-13);
    const Matrix6d J = EulerJacobian(X);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = kStep * Vector6d::Unit(i);
      const Vector6d difference = (EulerOf(Plus(X, step)) - EulerOf(Plus(X, -step))) / (2 * kStep);
      // The third derivative grows as 1 / cos(pitch)^3, at most some 200: 200 kStep^2 / 6.
      EXPECT_LT((difference - J.col(i)).norm(), 1e-8);
    }
  }
  EXPECT_LT((EulerOf(Pose(RotX(0.3), {1, 2, 3})) - (Vector6d() << 1, 2, 3, 0.3, 0, 0).finished()).norm(), 1e-15);
}

TEST(ErrorPropagation, CovarianceOfTheMotionIsThatOfTheImplicitFunctionByAutodiff) {
  RandomStream random(2, "autodiff");
  for (int trial = 0; trial < 20; ++trial) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = random.Uniform(-1, 1);
    // Large residuals, so that the terms of second derivatives count.
    const auto matches = NoisyMatches(PoseOfEuler(d), 0.3, random);
    const Pose X_AB = RefineRigidMotion(
                          [&] {
                            auto equal = matches;  // equal weights: the minimum of Eq. 2.28, to rounding
                            for (auto& match : equal) match.covariance_A = match.covariance_B = Matrix3d::Identity();
                            return equal;
                          }(),
                          FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB)
                          .X_AB;
    Eigen::VectorXd points(6 * kPoints);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6 * kPoints, 6 * kPoints);
    for (int k = 0; k < kPoints; ++k) {
      const PointMatch& match = matches[size_t(k)];
      points.segment<6>(6 * k) << match.p_A, match.p_B;
      covariance.block<3, 3>(6 * k, 6 * k) = match.covariance_A;
      covariance.block<3, 3>(6 * k + 3, 6 * k + 3) = match.covariance_B;
    }
    const Eigen::MatrixXd J = ImplicitJacobian<6 * kPoints, 6>(DistancesInEuler(), points, EulerOf(X_AB));
    const auto jacobians = MotionJacobians(matches, X_AB, MotionCost::kDistances);
    const Matrix6d to_euler = EulerJacobian(X_AB);
    Eigen::MatrixXd closed(6, 6 * kPoints);
    for (int k = 0; k < kPoints; ++k)
      closed.middleCols<6>(6 * k) << to_euler * jacobians[size_t(k)].by_A, to_euler * jacobians[size_t(k)].by_B;
    EXPECT_LT((closed - J).norm(), 1e-9 * J.norm());
    const Matrix6d tangent = CovarianceOfMotion(matches, jacobians);
    const Eigen::MatrixXd expected = J * covariance * J.transpose();
    EXPECT_LT((to_euler * tangent * to_euler.transpose() - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(ErrorPropagation, LikelihoodsCovarianceIsTheInverseInformationWithoutResiduals) {
  RandomStream random(3, "information");
  const Pose X_AB(ExpSo3({0.2, 0.1, -0.3}), {0.3, 0.2, 0.1});
  const auto matches = NoisyMatches(X_AB, 0, random);
  const Matrix6d expected = RefineRigidMotion(matches, X_AB).covariance;
  const Matrix6d propagated =
      CovarianceOfMotion(matches, MotionJacobians(matches, X_AB, MotionCost::kMaximumLikelihood));
  EXPECT_LT((propagated - expected).norm(), 1e-9 * expected.norm());
}

TEST(ErrorPropagation, PixelsToMotionIsThatOfMonteCarloWithinItsOwnError) {
  RandomStream random(4, "pairs");
  constexpr double kSigma_px = 0.2;
  const TwoPairs pairs(ChapterRig(), 30, kSigma_px, 0.15, random);
  const auto exact = pairs.Points(0, random);
  const PropagatedMotion motion = PropagateMotion(exact, pairs.X_AB, MotionCost::kDistances);
  EXPECT_TRUE(motion.first_order_holds);
  constexpr int kSamples = 10000;
  Vector6d mean = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const auto matches = MatchesOf(pairs.Points(kSigma_px, random));
    const Vector6d error = Minus(FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB, pairs.X_AB);
    mean += error / kSamples;
    covariance += error * error.transpose() / kSamples;
  }
  covariance -= mean * mean.transpose();
  const Matrix6d L = motion.covariance.llt().matrixL();
  const Matrix6d whitened = L.inverse() * covariance * L.inverse().transpose();
  // A sampled variance errs by sqrt(2 / n) = 1.4 %, 4 of which in 21 entries happen in one seed of 700; second order
  // adds (sigma_z / z)^2, 0.01 % here.
  EXPECT_LT((whitened - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 4 * std::sqrt(2.0 / kSamples));
}

TEST(ErrorPropagation, BiasOfTheMotionIsTheMeanErrorOfMonteCarlo) {
  RandomStream random(5, "bias");
  constexpr double kSigma_px = 2;
  constexpr StereoCost kCost = StereoCost::kMaximumLikelihood;  // the algebraic one has next to none
  const TwoPairs pairs(ChapterRig(), 40, kSigma_px, 1.5, random);
  const PropagatedMotion motion = PropagateMotion(pairs.Points(0, random, kCost), pairs.X_AB, MotionCost::kDistances);
  constexpr int kSamples = 5000;
  Vector6d mean = Vector6d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const auto matches = MatchesOf(pairs.Points(kSigma_px, random, kCost));
    mean += Minus(FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB, pairs.X_AB) / kSamples;
  }
  const Matrix6d L = motion.covariance.llt().matrixL();
  const Vector6d measured = L.inverse() * mean, propagated = L.inverse() * motion.bias;
  // So the comparison says something. The biases of points nearly cancel unless the step is large.
  EXPECT_GT(propagated.norm(), 0.1);
  // 4 standard deviations of a mean; the motion's own curvature and fourth order are a fifth of the bias here at most.
  EXPECT_LT((measured - propagated).norm(), 4 / std::sqrt(double(kSamples)) + 0.2 * propagated.norm());
}

}  // namespace
}  // namespace gaitcam
