#include "algorithms/geometry/inverse_depth.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/geometry/ransac.h"

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

/// A sighting as two directions that the turn brings together.
struct DirectionPair {
  Eigen::Vector3d in_W, in_C;  ///< Unit vectors.
  double variance = 0;         ///< Of the angle between them, along each axis.
  double gain = 0;             ///< Twice the log-likelihood ratio to chance where they meet exactly.

  double Gain(const Eigen::Matrix3d& R_WC) const {
    return std::max(0.0, gain - 2 * (1 - in_W.dot(R_WC * in_C)) / variance);
  }
};

std::vector<DirectionPair> DirectionPairs(const std::vector<InverseDepthSighting>& sightings,
                                          const PositionPrior& prior, double field) {
  std::vector<DirectionPair> pairs;
  for (const InverseDepthSighting& sighting : sightings) {
    const InverseDepthPoint& point = sighting.point;
    const Eigen::Vector3d baseline = point.X_WA.translation - prior.position_W,
                          h = point.X_WA.R() * point.xy.homogeneous() + point.rho * baseline;
    const double length = std::max(h.norm(), kNearest), shift = point.rho * prior.sigma / length,
                 depth = point.rho_sigma * h.cross(baseline).norm() / (length * length);
    DirectionPair pair{h / length, sighting.xy.homogeneous().normalized()};
    pair.variance = sighting.sigma * sighting.sigma + point.xy_sigma * point.xy_sigma + shift * shift + depth * depth;
    pair.gain = 2 * std::log(std::max(1.0, field / (2 * M_PI * pair.variance)));
    pairs.push_back(pair);
  }
  return pairs;
}

/// The turn that brings two directions into the plane of their counterparts, both as near to them as can be.
std::optional<Eigen::Matrix3d> TurnOfTwo(const DirectionPair& a, const DirectionPair& b) {
  const double angle_W = std::atan2(a.in_W.cross(b.in_W).norm(), a.in_W.dot(b.in_W)),
               angle_C = std::atan2(a.in_C.cross(b.in_C).norm(), a.in_C.dot(b.in_C));
  const double off = angle_W - angle_C;
  constexpr double kSmallest = 0.02;  // rad between directions that tell a turn
  if (angle_W < kSmallest || angle_C < kSmallest || off * off > 9 * (a.variance + b.variance)) return {};
  const auto frame = [](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    Eigen::Matrix3d F;
    F.col(0) = (u + v).normalized();
    F.col(2) = u.cross(v).normalized();
    F.col(1) = F.col(2).cross(F.col(0));
    return F;
  };
  return frame(a.in_W, b.in_W) * frame(a.in_C, b.in_C).transpose();
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
                double huber, const std::optional<PositionPrior>& prior) {
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
    if (prior) {
      const double information = 1 / (prior->sigma * prior->sigma);
      H.bottomRightCorner<3, 3>() += information * Eigen::Matrix3d::Identity();
      g.tail<3>() += information * (pose.translation - prior->position_W);
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

TurnResult EstimateTurn(const std::vector<InverseDepthSighting>& sightings, const PositionPrior& prior,
                        const Eigen::Quaterniond& guess, double field, RandomStream& random) {
  TurnResult result{Pose(guess, prior.position_W), {}};
  const std::vector<DirectionPair> pairs = DirectionPairs(sightings, prior, field);
  const int n = int(pairs.size());
  if (n < 3) return result;
  const auto judge = [&](const Eigen::Matrix3d& R_WC) {
    double gain = 0;
    for (const DirectionPair& pair : pairs) gain += pair.Gain(R_WC);
    return gain;
  };
  Eigen::Matrix3d best = guess.toRotationMatrix();
  double most = judge(best);
  constexpr int kSamples = 1000;      // most are refused at once: their angles differ
  constexpr double kWork = 100000.0;  // sightings judged in all
  int judged = 0;
  for (int k = 0; k < kSamples && judged * n < kWork; ++k) {
    const std::vector<int> two = internal::DrawSample(n, 2, random);
    const auto R_WC = TurnOfTwo(pairs[size_t(two[0])], pairs[size_t(two[1])]);
    if (!R_WC) continue;
    ++judged;
    const double gain = judge(*R_WC);
    if (gain <= most) continue;
    most = gain;
    best = *R_WC;
  }
  result.X_WC.rotation = Eigen::Quaterniond(best);
  for (int i = 0; i < n; ++i) {
    const DirectionPair& pair = pairs[size_t(i)];
    if (pair.Gain(best) > 0) result.inliers.push_back(i);
    result.chance += std::min(1.0, M_PI * pair.gain * pair.variance / field);
  }
  if (result.inliers.size() < 3) result.inliers.clear();
  return result;
}

}  // namespace gaitcam
