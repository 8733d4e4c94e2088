#include "algorithms/geometry/triangulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

Eigen::Vector3d RayInWorld(const RayObservation& observation) {
  return (observation.X_WC.rotation * observation.xy.homogeneous()).normalized();
}

/// Minimises sum |(I - d d^T)(p - c)|^2 over rays from c along d.
std::optional<Eigen::Vector3d> NearestToRays(const std::vector<RayObservation>& observations) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const RayObservation& observation : observations) {
    const Eigen::Vector3d d = RayInWorld(observation);
    const Eigen::Matrix3d M = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += M;
    b += M * observation.X_WC.translation;
  }
  constexpr double kParallel = 1e-9;  // some 3e-5 rad between two rays
  if (!(EigenOfSymmetric(A).values[0] > kParallel)) return std::nullopt;
  return SolveSymmetric<3>(A, b);
}

/// One Gauss-Newton step on the reprojection errors; false if the point is behind a camera.
bool Refine(const std::vector<RayObservation>& observations, Eigen::Vector3d& p_W) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const RayObservation& observation : observations) {
    const Eigen::Matrix3d R_CW = observation.X_WC.R().transpose();
    const Eigen::Vector3d p = R_CW * (p_W - observation.X_WC.translation);
    if (!(p.z() > 0)) return false;
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
    const Eigen::Matrix<double, 2, 3> J = projection * R_CW;
    H += J.transpose() * J;
    g += J.transpose() * (p.hnormalized() - observation.xy);
  }
  p_W -= SolveSymmetric<3>(H, g);
  return p_W.allFinite();
}

}  // namespace

std::optional<Eigen::Vector3d> TriangulatePoint(const std::vector<RayObservation>& observations) {
  std::optional<Eigen::Vector3d> p_W = NearestToRays(observations);
  if (!p_W) return std::nullopt;
  constexpr int kSteps = 3;
  for (int step = 0; step < kSteps; ++step) {
    if (!Refine(observations, *p_W)) return std::nullopt;
  }
  for (const RayObservation& observation : observations) {
    if (!std::isfinite(ReprojectionError(*p_W, observation))) return std::nullopt;
  }
  return p_W;
}

double ParallaxAngle(const Eigen::Vector3d& p_W, const std::vector<RayObservation>& observations) {
  double min_cosine = 1;
  for (size_t i = 0; i < observations.size(); ++i) {
    const Eigen::Vector3d a = (p_W - observations[i].X_WC.translation).normalized();
    for (size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d b = (p_W - observations[j].X_WC.translation).normalized();
      min_cosine = std::min(min_cosine, a.dot(b));
    }
  }
  return std::acos(std::clamp(min_cosine, -1.0, 1.0));
}

double ReprojectionError(const Eigen::Vector3d& p_W, const RayObservation& observation) {
  const Eigen::Vector3d p = observation.X_WC.rotation.conjugate() * (p_W - observation.X_WC.translation);
  if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
  return (p.hnormalized() - observation.xy).norm();
}

}  // namespace gaitcam
