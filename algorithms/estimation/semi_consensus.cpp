#include "algorithms/estimation/semi_consensus.h"

#include <Eigen/Cholesky>

#include "algorithms/core/errors.h"

namespace gaitcam {

Pose MahalanobisMean(const std::vector<LikelyPose>& poses) {
  GAITCAM_ASSERT(!poses.empty());
  constexpr int kSteps = 20;
  constexpr double kArrived = 1e-12;  // m and rad
  Pose mean = poses.front().X;
  for (int step = 0; step < kSteps; ++step) {
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (const LikelyPose& pose : poses) {
      const Vector6d e = Minus(mean, pose.X);
      const Matrix6d J = RightJacobianInverseSe3(e);
      const Matrix6d W = pose.covariance.llt().solve(Matrix6d::Identity());
      information += J.transpose() * W * J;
      gradient += J.transpose() * W * e;
    }
    const Vector6d change = -information.llt().solve(gradient);
    mean = Plus(mean, change);
    if (change.norm() < kArrived) break;
  }
  return mean;
}

void ReachSemiConsensus(std::span<Pose> chain, const Pose& closed, double alpha) {
  if (chain.size() < 2) return;
  const Vector6d difference = LogSe3(closed * chain.back().Inverse());  // Eq. 6.3
  const double links = double(chain.size() - 1);                        // b - a
  // Eq. 6.4, and the poses rebuilt of it by Eq. 6.1: after k links the world has moved by k parts of the difference.
  for (size_t k = 1; k < chain.size(); ++k) chain[k] = ExpSe3(alpha * double(k) / links * difference) * chain[k];
}

}  // namespace gaitcam
