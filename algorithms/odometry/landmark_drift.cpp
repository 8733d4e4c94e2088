#include "algorithms/odometry/landmark_drift.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gaitcam {

Matrix6d DifferenceOfLandmarks(const LandmarkGains& before, const LandmarkGains& now,
                               const std::vector<StereoLandmark>& landmarks) {
  std::map<int, Eigen::Matrix<double, 6, 3>> gains = now.by_landmark;
  const Matrix6d carry = Adjoint(now.X_WC.Inverse() * before.X_WC);
  for (const auto& [landmark, gain] : before.by_landmark) {
    const auto [at, is_new] = gains.try_emplace(landmark, Eigen::Matrix<double, 6, 3>::Zero());
    at->second -= carry * gain;
  }
  Matrix6d covariance = Matrix6d::Zero();
  for (const auto& [landmark, gain] : gains) {
    covariance += gain * landmarks[size_t(landmark)].covariance_W * gain.transpose();
  }
  return covariance;
}

void GrowingCovariance::Add(const Pose& X_WC, const Matrix6d& covariance) {
  const Matrix6d before = CarryCovariance(covariance_, last_.Inverse() * X_WC);
  covariance_ = before + PositivePart(covariance - before, covariance + before);
  last_ = X_WC;
}

double GrowingCovariance::ShareOf(const Matrix6d& whole) const {
  const Eigen::LLT<Matrix6d> factors(whole);
  if (factors.info() != Eigen::Success) return 1;
  return std::clamp(factors.solve(covariance_).trace() / 6, 0.0, 1.0);
}

}  // namespace gaitcam
