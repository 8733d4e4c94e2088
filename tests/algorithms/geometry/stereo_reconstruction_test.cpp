#include "algorithms/geometry/stereo_reconstruction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "algorithms/core/random.h"
#include "tests/algorithms/geometry/implicit_jacobian.h"
#include "tests/algorithms/geometry/stereo_rigs.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

const StereoCost kCosts[] = {StereoCost::kAlgebraic, StereoCost::kMaximumLikelihood};

/// The vertical errors as a part of the horizontal ones.
StereoSighting Noisy(StereoSighting sighting, double sigma_px, RandomStream& random, double vertical = 1) {
  sighting.left += sigma_px * Eigen::Vector2d(random.Normal(), vertical * random.Normal());
  sighting.right += sigma_px * Eigen::Vector2d(random.Normal(), vertical * random.Normal());
  sighting.covariance_left = sigma_px * sigma_px * Eigen::Vector2d(1, vertical * vertical).asDiagonal();
  sighting.covariance_right = sighting.covariance_left;
  return sighting;
}

/// The sighting with its four pixel coordinates moved.
StereoSighting Moved(StereoSighting sighting, const Eigen::Vector4d& by_px) {
  sighting.left += by_px.head<2>();
  sighting.right += by_px.tail<2>();
  return sighting;
}

TEST(StereoReconstruction, ExactPixelsGiveThePointThroughDistortionAndRotation) {
  RandomStream random(1, "exact");
  for (const StereoRig& rig : {ChapterRig(), DistortedRig()}) {
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3d p = PointInView(rig, 0.8, 20, random);
      for (const StereoCost cost : kCosts) {
        const StereoPoint point = ReconstructPoint(rig, SeenBy(rig, p), {cost, 0});
        ASSERT_TRUE(point.ok());
        EXPECT_LT((point.p_L - p).norm(), 1e-9 * p.squaredNorm());  // 1e-12 px of undistortion grow as depth squared
        EXPECT_LT(point.squared_error, 1e-12);
      }
    }
  }
}

/// Eq. 2.25, written down for jets of jets: u, v, u', v', then p.
struct AlgebraicCost {
  const StereoRig& rig;
  template <class T>
  T operator()(const std::array<T, 7>& x) const {
    const Pose X_RL = rig.X_LR.Inverse();
    const Matrix3d R = X_RL.R();
    const std::array<T, 3> p{x[4], x[5], x[6]};
    std::array<T, 3> q;
    for (int i = 0; i < 3; ++i)
      q[size_t(i)] = Number<T>(R(i, 0)) * p[0] + Number<T>(R(i, 1)) * p[1] + Number<T>(R(i, 2)) * p[2] +
                     Number<T>(X_RL.translation[i]);
    const T a = (x[0] - Number<T>(rig.left.cx)) * p[2] - Number<T>(rig.left.fx) * p[0];
    const T b = (x[1] - Number<T>(rig.left.cy)) * p[2] - Number<T>(rig.left.fy) * p[1];
    const T c = (x[2] - Number<T>(rig.right.cx)) * q[2] - Number<T>(rig.right.fx) * q[0];
    const T d = (x[3] - Number<T>(rig.right.cy)) * q[2] - Number<T>(rig.right.fy) * q[1];
    return a * a + b * b + c * c + d * d;
  }
};

/// The reprojection error over unit covariances.
struct ReprojectionCost {
  const StereoRig& rig;
  template <class T>
  T operator()(const std::array<T, 7>& x) const {
    const Pose X_RL = rig.X_LR.Inverse();
    const Matrix3d R = X_RL.R();
    std::array<T, 3> q;
    for (int i = 0; i < 3; ++i)
      q[size_t(i)] = Number<T>(R(i, 0)) * x[4] + Number<T>(R(i, 1)) * x[5] + Number<T>(R(i, 2)) * x[6] +
                     Number<T>(X_RL.translation[i]);
    const T a = Number<T>(rig.left.fx) * x[4] / x[6] + Number<T>(rig.left.cx) - x[0];
    const T b = Number<T>(rig.left.fy) * x[5] / x[6] + Number<T>(rig.left.cy) - x[1];
    const T c = Number<T>(rig.right.fx) * q[0] / q[2] + Number<T>(rig.right.cx) - x[2];
    const T d = Number<T>(rig.right.fy) * q[1] / q[2] + Number<T>(rig.right.cy) - x[3];
    return a * a + b * b + c * c + d * d;
  }
};

TEST(StereoReconstruction, JacobianIsThatOfTheImplicitFunctionByAutodiff) {
  RandomStream random(2, "autodiff");
  StereoRig rig = ChapterRig();
  rig.right.fx *= 1.2;  // every number different
  rig.right.fy *= 0.9;
  for (int trial = 0; trial < 50; ++trial) {
    const StereoSighting seen = Noisy(SeenBy(rig, PointInView(rig, 1, 10, random)), 1, random);
    const Eigen::Vector4d u(seen.left.x(), seen.left.y(), seen.right.x(), seen.right.y());
    for (const StereoCost cost : kCosts) {
      const StereoPoint point = ReconstructPoint(rig, seen, {cost, 0});
      ASSERT_TRUE(point.ok());
      const Eigen::MatrixXd expected = cost == StereoCost::kAlgebraic
                                           ? ImplicitJacobian<4, 3>(AlgebraicCost{rig}, u, point.p_L)
                                           : ImplicitJacobian<4, 3>(ReprojectionCost{rig}, u, point.p_L);
      EXPECT_LT((point.J - expected).norm(), 1e-9 * expected.norm());
    }
  }
}

TEST(StereoReconstruction, JacobianHoldsThroughDistortion) {
  RandomStream random(3, "distorted");
  const StereoRig rig = DistortedRig();
  for (int trial = 0; trial < 20; ++trial) {
    const StereoSighting seen = SeenBy(rig, PointInView(rig, 0.5, 3, random));
    for (const StereoCost cost : kCosts) {
      const StereoPoint point = ReconstructPoint(rig, seen, {cost, 0});
      constexpr double kStep_px = 1e-3;
      for (int i = 0; i < 4; ++i) {
        const Eigen::Vector4d step = kStep_px * Eigen::Vector4d::Unit(i);
        const Vector3d difference = ReconstructPoint(rig, Moved(seen, step), {cost, 0}).p_L -
                                    ReconstructPoint(rig, Moved(seen, -step), {cost, 0}).p_L;
        // Central differences err by the third derivative times 1e-6 / 6, some 1e-6 of the first here.
        EXPECT_LT((difference / (2 * kStep_px) - point.J.col(i)).norm(), 1e-5 * point.J.norm());
      }
    }
  }
}

TEST(StereoReconstruction, BiasIsTheMeanErrorOfSecondOrderAndCovarianceThatOfMonteCarlo) {
  const StereoRig rig = ChapterRig();
  const Vector3d p(0.4, -0.3, 5);
  constexpr double kSigma_px = 1, kVertical = 0.5;  // unequal, lest the algebraic cost's two biases cancel
  for (const StereoCost cost : kCosts) {
    RandomStream random(4, "bias");
    StereoSighting exact = Noisy(SeenBy(rig, p), kSigma_px, random, kVertical);
    exact.left = SeenBy(rig, p).left;
    exact.right = SeenBy(rig, p).right;
    const StereoPoint point = ReconstructPoint(rig, exact, {cost, 0});
    constexpr int kSamples = 100000;
    Vector3d mean = Vector3d::Zero();
    Matrix3d covariance = Matrix3d::Zero();
    for (int i = 0; i < kSamples; ++i) {
      const Vector3d error = ReconstructPoint(rig, Noisy(exact, kSigma_px, random, kVertical), {cost, 0}).p_L - p;
      mean += error / kSamples;
      covariance += error * error.transpose() / kSamples;
    }
    covariance -= mean * mean.transpose();
    // A mean's standard deviation; 3.5 of it in three coordinates happens once in 700 seeds. Terms of fourth order are
    // (sigma_z / z)^2, some 0.1 %, of the bias.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], point.bias[k], 3.5 * std::sqrt(covariance(k, k) / kSamples));
    EXPECT_GT(std::abs(point.bias.z()),
              7 * std::sqrt(covariance(2, 2) / kSamples));  // so the comparison says something
    // In units of the propagated deviations. Entries of a sampled covariance err by up to sqrt(2 / n) = 0.4 %; the
    // terms of fourth order, 8 (sigma_z / z)^2, are 0.6 %.
    const Matrix3d L = point.covariance.llt().matrixL();
    const Matrix3d whitened = L.inverse() * covariance * L.inverse().transpose();
    EXPECT_LT((whitened - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.02);
  }
}

TEST(StereoReconstruction, TermsOfSecondOrderAreThoseOfDifferences) {
  RandomStream random(5, "second");
  const StereoRig rig = ChapterRig();
  const Eigen::Vector4d variances(1, 0.25, 0.5, 0.1);
  for (int trial = 0; trial < 20; ++trial) {
    StereoSighting seen = SeenBy(rig, PointInView(rig, 1, 6, random));
    seen.covariance_left.diagonal() = variances.head<2>();
    seen.covariance_right.diagonal() = variances.tail<2>();
    for (const StereoCost cost : kCosts) {
      const StereoPoint point = ReconstructPoint(rig, seen, {cost, 0});
      // The bias is half of the sum of the second derivatives by each coordinate, times its variance.
      Vector3d twice = Vector3d::Zero();
      constexpr double kStep_px = 0.02;
      for (int i = 0; i < 4; ++i) {
        const Eigen::Vector4d step = kStep_px * Eigen::Vector4d::Unit(i);
        twice += variances[i] *
                 (ReconstructPoint(rig, Moved(seen, step), {cost, 0}).p_L +
                  ReconstructPoint(rig, Moved(seen, -step), {cost, 0}).p_L - 2 * point.p_L) /
                 (kStep_px * kStep_px);
      }
      // Rounding of 1e-12 px grows to some 1e-6 of it, the fourth derivative is some 1e-7.
      EXPECT_LT((point.bias - twice / 2).norm(), 1e-4 * point.bias.norm());
    }
  }
}

TEST(StereoReconstruction, AlgebraicBiasesCancelWherePixelsErrAlikeInBothDirections) {
  const StereoRig rig = ChapterRig();
  const StereoSighting seen = SeenBy(rig, {0.4, -0.3, 5});
  const StereoPoint algebraic = ReconstructPoint(rig, seen, {StereoCost::kAlgebraic, 0});
  const StereoPoint likely = ReconstructPoint(rig, seen, {StereoCost::kMaximumLikelihood, 0});
  // (sigma_z / z)^2 z with sigma_z = sqrt(2) z^2 / (f b), to the rig's rotations.
  const double inverted = 2 * std::pow(5, 3) / std::pow(rig.left.fx * 0.385, 2);
  EXPECT_NEAR(likely.bias.z(), inverted, 0.1 * inverted);
  EXPECT_LT(std::abs(algebraic.bias.z()), 0.01 * inverted);
}

TEST(StereoReconstruction, LikelihoodUsesCovariancesAndLosesToNothing) {
  // One image's rows are poorly known: weighting them less must reduce the error, measured over the same samples.
  const StereoRig rig = DistortedRig();
  RandomStream random(6, "anisotropic");
  double likely = 0, algebraic = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d p = PointInView(rig, 1, 2, random);
    StereoSighting seen = SeenBy(rig, p);
    seen.covariance_left << 0.04, 0, 0, 9;
    seen.covariance_right << 0.04, 0, 0, 0.04;
    seen.left += Eigen::Vector2d(0.2 * random.Normal(), 3 * random.Normal());
    seen.right += 0.2 * Eigen::Vector2d(random.Normal(), random.Normal());
    const StereoPoint a = ReconstructPoint(rig, seen, {StereoCost::kMaximumLikelihood, 0});
    const StereoPoint b = ReconstructPoint(rig, seen, {StereoCost::kAlgebraic, 0});
    ASSERT_TRUE(a.ok() && b.ok());
    likely += (a.p_L - p).squaredNorm();
    algebraic += (b.p_L - p).squaredNorm();
    EXPECT_LE(a.squared_error, b.squared_error * (1 + 1e-9));
  }
  EXPECT_LT(likely, 0.5 * algebraic);
}

TEST(StereoReconstruction, SquaredErrorIsChiSquareOfOneDegree) {
  const StereoRig rig = DistortedRig();
  RandomStream random(7, "chi-square");
  constexpr int kSamples = 20000;
  double mean = 0;
  int beyond = 0;
  for (int i = 0; i < kSamples; ++i) {
    const StereoPoint point = ReconstructPoint(rig, Noisy(SeenBy(rig, PointInView(rig, 1, 3, random)), 0.5, random));
    ASSERT_TRUE(point.ok());
    mean += point.squared_error / kSamples;
    beyond += point.squared_error > 3.841;  // 5 %
  }
  EXPECT_NEAR(mean, 1, 4 * std::sqrt(2.0 / kSamples));
  EXPECT_NEAR(double(beyond) / kSamples, 0.05, 4 * std::sqrt(0.05 * 0.95 / kSamples));
}

TEST(StereoReconstruction, WhatCannotBeReconstructedIsAStatusAndNotANumber) {
  const StereoRig rig = ChapterRig();
  const auto status = [&](const StereoSighting& sighting, const ReconstructionOptions& options = {}) {
    const StereoPoint point = ReconstructPoint(rig, sighting, options);
    EXPECT_TRUE(point.ok() || point.p_L.array().isNaN().all());
    EXPECT_TRUE(point.ok() || !point.first_order_holds);
    return point.status;
  };
  // Both images of one direction, by a rotation alone.
  StereoSighting infinite;
  const Vector3d direction(0.1, 0.05, 1);
  infinite.left = *rig.left.Project(direction);
  infinite.right = *rig.right.Project(rig.X_LR.rotation.conjugate() * direction);
  EXPECT_EQ(status(infinite), StereoStatus::kParallel);
  EXPECT_EQ(status(Moved(infinite, {0, 0, 20, 0})), StereoStatus::kBehind);
  EXPECT_EQ(status(Moved(infinite, {0, 0, -2, 0})), StereoStatus::kTooFar);  // 2 px of disparity, known to sqrt(2) px
  EXPECT_EQ(status(Moved(infinite, {0, 0, -2, 0}), {StereoCost::kAlgebraic, 0}), StereoStatus::kOk);
  EXPECT_EQ(status(Moved(infinite, {0, 0, -20, 0})), StereoStatus::kOk);
  EXPECT_EQ(status(Moved(infinite, {0, std::numeric_limits<double>::quiet_NaN(), 0, 0})), StereoStatus::kNoRay);

  StereoRig barrel = rig;  // its largest radius is short of the image's corner
  barrel.left.k1 = -0.8;
  StereoSighting corner = SeenBy(rig, {0, 0, 2});
  corner.left = {0, 0};
  EXPECT_EQ(ReconstructPoint(barrel, corner).status, StereoStatus::kNoRay);
}

TEST(StereoReconstruction, FirstOrderIsSaidToHoldWhereItDoes) {
  const StereoRig rig = ChapterRig();
  const auto at = [&](double depth_m, double sigma_px) {
    StereoSighting seen = SeenBy(rig, {0, 0, depth_m});
    seen.covariance_left = seen.covariance_right *= sigma_px * sigma_px;
    return ReconstructPoint(rig, seen, {StereoCost::kMaximumLikelihood, 0});
  };
  // sigma_z / z is sqrt(2) sigma z / (f b), here f b = 213 px m.
  EXPECT_TRUE(at(5, 2).first_order_holds);
  EXPECT_FALSE(at(40, 2).first_order_holds);
  // Squared, 1 from the bias of the inverted disparity, 2 from its spread, 1 from x and y each, which the depth scales.
  EXPECT_NEAR(at(40, 0.5).nonlinearity, std::sqrt(5 * 2) * 0.5 * 40 / (rig.left.fx * 0.385), 0.01);
}

TEST(StereoRig, SwappedImagesAreToldFromDisparities) {
  for (const StereoRig& rig : {ChapterRig(), DistortedRig()}) {
    RandomStream random(8, "order");
    std::vector<StereoSighting> matches, swapped;
    for (int i = 0; i < 40; ++i) {
      StereoSighting seen = Noisy(SeenBy(rig, PointInView(rig, 0.6, 4, random)), 0.5, random);
      if (i % 4 == 0) seen.right = {random.Uniform(0, 639), random.Uniform(0, 479)};  // a mismatch
      matches.push_back(seen);
      std::swap(seen.left, seen.right);
      swapped.push_back(seen);
    }
    EXPECT_EQ(TellImageOrder(rig, matches), ImageOrder::kRight);
    EXPECT_EQ(TellImageOrder(rig, swapped), ImageOrder::kSwapped);
    EXPECT_EQ(TellImageOrder(rig, {matches.begin(), matches.begin() + 9}), ImageOrder::kUnknown);
    matches.insert(matches.end(), swapped.begin(), swapped.end());
    EXPECT_EQ(TellImageOrder(rig, matches), ImageOrder::kUnknown);
  }
}

TEST(StereoRig, ACalibrationThatIsNoRigIsRefusedInOneLine) {
  Calibration calibration;
  calibration.camera = ChapterRig().left;
  EXPECT_THAT(ErrorOf([&] { StereoRig::Of(calibration); }), HasSubstr("no right camera"));
  calibration.right = calibration.camera;
  EXPECT_THAT(ErrorOf([&] { StereoRig::Of(calibration); }), HasSubstr("baseline above 0"));
  calibration.X_LR = Pose(RotY(1.5), {0.1, 0, 0});
  EXPECT_THAT(ErrorOf([&] { StereoRig::Of(calibration); }), HasSubstr("see at most 0 %"));
  calibration.X_LR.rotation.coeffs().setConstant(0.9);
  EXPECT_THAT(ErrorOf([&] { StereoRig::Of(calibration); }), HasSubstr("quaternion has length 1.8"));
  calibration.X_LR = Pose(RotY(0.02), {0.1, 0, 0});
  EXPECT_NO_THROW(StereoRig::Of(calibration));
  calibration.right->fx = 0;
  EXPECT_THAT(ErrorOf<BadOption>([&] { StereoRig::Of(calibration); }), HasSubstr("focal lengths"));
}

TEST(StereoRig, OverlapGrowsWithDepthForParallelCameras) {
  StereoRig rig = ChapterRig();
  rig.X_LR.rotation.setIdentity();
  const double width_m = rig.left.width_px / rig.left.fx;  // of the view at 1 m
  EXPECT_EQ(rig.Overlap(0.9 * 0.385 / width_m), 0);
  EXPECT_NEAR(rig.Overlap(2), 1 - 0.385 / (2 * width_m), 1.0 / 24);  // to one column of the grid
  EXPECT_GT(rig.Overlap(1000), 0.95);
}

}  // namespace
}  // namespace gaitcam
