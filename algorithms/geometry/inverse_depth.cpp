#include "algorithms/geometry/inverse_depth.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace gaitcam {
namespace {

constexpr double kNearest = 1e-6;  // smallest h.z: rays nearly at right angles to the optical axis have no image

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Eigen::Matrix2d Covariance(const InverseDepthSighting& sighting, const Eigen::Vector2d& d_rho) {
  const double variance = sighting.point.rho_sigma * sighting.point.rho_sigma;
  const double place = sighting.sigma * sighting.sigma + sighting.point.xy_sigma * sighting.point.xy_sigma;
  return place * Eigen::Matrix2d::Identity() + variance * d_rho * d_rho.transpose();
}

}  // namespace

std::optional<Eigen::Vector2d> ProjectInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                   const Pose& X_WC) {
  const Eigen::Vector3d h =
      X_WC.rotation.conjugate() * (X_WA.rotation * xy.homogeneous() + rho * (X_WA.translation - X_WC.translation));
  if (!(h.z() > kNearest)) return {};
  return h.hnormalized();
}

std::optional<InverseDepthProjection> LinearizeInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                            const Pose& X_WC) {
  const Eigen::Matrix3d R_A = X_WA.R(), R_CW = X_WC.R().transpose();
  const Eigen::Vector3d b = xy.homogeneous(), baseline = X_WA.translation - X_WC.translation;
  const Eigen::Vector3d h = R_CW * (R_A * b + rho * baseline);
  if (!(h.z() > kNearest)) return {};
  InverseDepthProjection out;
  out.xy = h.hnormalized();
  Eigen::Matrix<double, 2, 3> d_h;
  d_h << 1 / h.z(), 0, -h.x() / (h.z() * h.z()), 0, 1 / h.z(), -h.y() / (h.z() * h.z());
  out.d_anchor.leftCols<3>() = -d_h * R_CW * R_A * Skew(b);
  out.d_anchor.rightCols<3>() = rho * d_h * R_CW;
  out.d_camera.leftCols<3>() = d_h * Skew(h);
  out.d_camera.rightCols<3>() = -rho * d_h * R_CW;
  out.d_xy = d_h * (R_CW * R_A).leftCols<2>();
  out.d_rho = d_h * (R_CW * baseline);
  return out;
}

double Mahalanobis2(const InverseDepthSighting& sighting, const Pose& X_WC) {
  const InverseDepthPoint& point = sighting.point;
  const auto projection = LinearizeInverseDepth(point.X_WA, point.xy, point.rho, X_WC);
  if (!projection) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d e = projection->xy - sighting.xy;
  return e.dot(Covariance(sighting, projection->d_rho).inverse() * e);
}

Pose RefinePose(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                double huber) {
  Pose pose = X_WC;
  constexpr int kMostSteps = 10;
  constexpr double kConverged = 1e-9, kLargestTurn = 0.5;  // rad; beyond it the linearisation is worthless
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (const int i : use) {
      const InverseDepthSighting& sighting = sightings[size_t(i)];
      const InverseDepthPoint& point = sighting.point;
      const auto projection = LinearizeInverseDepth(point.X_WA, point.xy, point.rho, pose);
      if (!projection) continue;
      const Eigen::Matrix2d information = Covariance(sighting, projection->d_rho).inverse();
      const Eigen::Vector2d e = projection->xy - sighting.xy;
      const double distance = std::sqrt(e.dot(information * e));
      const double weight = distance > huber ? huber / distance : 1.0;
      H += weight * projection->d_camera.transpose() * information * projection->d_camera;
      g += weight * projection->d_camera.transpose() * information * e;
    }
    // Where all points are at infinity translation is free: a whisper of damping keeps it where it is.
    H.bottomRightCorner<3, 3>() += 1e-9 * (1 + H.topLeftCorner<3, 3>().trace()) * Eigen::Matrix3d::Identity();
    const Vector6 change = -H.ldlt().solve(g);
    if (!change.allFinite() || change.head<3>().norm() > kLargestTurn) return step == 0 ? X_WC : pose;
    const Eigen::Vector3d w = change.head<3>();
    const double angle = w.norm();
    const Eigen::AngleAxisd turn(angle, angle > 0 ? Eigen::Vector3d(w / angle) : Eigen::Vector3d::UnitX());
    pose = Pose(pose.rotation * Eigen::Quaterniond(turn), pose.translation + change.tail<3>());
    if (change.norm() < kConverged) break;
  }
  return pose;
}

}  // namespace gaitcam
