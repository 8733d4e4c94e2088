#include "algorithms/geometry/inverse_depth.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/se3.h"
#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {
namespace {

constexpr double kMinDepth = 1e-6;  // of h.z: rays nearly at right angles to the optical axis have no image

/// @param guesses points whose guessed depths share one error: the variance of each is so many times its own
Eigen::Matrix2d Covariance(const InverseDepthSighting& sighting, const Eigen::Vector2d& d_rho, double guesses = 1) {
  const double variance = (sighting.point.is_guess ? guesses : 1) * sighting.point.rho_sigma * sighting.point.rho_sigma;
  const double image = sighting.sigma * sighting.sigma + sighting.point.xy_sigma * sighting.point.xy_sigma;
  return image * Eigen::Matrix2d::Identity() + variance * d_rho * d_rho.transpose();
}

/// A sighting as two directions that the rotation aligns.
struct DirectionPair {
  Eigen::Vector3d in_W, in_C;  ///< Unit vectors.
  double variance = 0;         ///< Of the angle between them, along each axis.
  double gain = 0;             ///< Twice the log-likelihood ratio to chance where they coincide.

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
    const double length = std::max(h.norm(), kMinDepth), shift = point.rho * prior.sigma / length,
                 depth = point.rho_sigma * h.cross(baseline).norm() / (length * length);
    DirectionPair pair{h / length, sighting.xy.homogeneous().normalized()};
    pair.variance = sighting.sigma * sighting.sigma + point.xy_sigma * point.xy_sigma + shift * shift + depth * depth;
    pair.gain = 2 * std::log(std::max(1.0, field / (2 * M_PI * pair.variance)));
    pairs.push_back(pair);
  }
  return pairs;
}

/// The rotation that aligns the plane and the bisector of two directions with those of their counterparts.
std::optional<Eigen::Matrix3d> TurnOfTwo(const DirectionPair& a, const DirectionPair& b) {
  const double angle_W = std::atan2(a.in_W.cross(b.in_W).norm(), a.in_W.dot(b.in_W)),
               angle_C = std::atan2(a.in_C.cross(b.in_C).norm(), a.in_C.dot(b.in_C));
  const double off = angle_W - angle_C;
  constexpr double kMinAngle = 0.02;  // rad between the two directions
  if (angle_W < kMinAngle || angle_C < kMinAngle || off * off > 9 * (a.variance + b.variance)) return {};
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
  if (!(h.z() > kMinDepth)) return {};
  return h.hnormalized();
}

std::optional<InverseDepthCamera::Sight> InverseDepthCamera::See(const AnchoredPoint& point) const {
  const Eigen::Vector3d baseline = point.anchor_W - position_W_;
  Sight sight;
  sight.h = R_CW_ * (point.ray_W + point.rho * baseline);
  const Eigen::Vector3d& h = sight.h;
  if (!(h.z() > kMinDepth)) return {};
  sight.xy = h.hnormalized();
  sight.d_xy << 1 / h.z(), 0, -h.x() / (h.z() * h.z()), 0, 1 / h.z(), -h.y() / (h.z() * h.z());
  sight.d_rho = sight.d_xy * (R_CW_ * baseline);
  return sight;
}

std::optional<Eigen::Vector2d> InverseDepthCamera::Project(const AnchoredPoint& point) const {
  const Eigen::Vector3d h = R_CW_ * (point.ray_W + point.rho * (point.anchor_W - position_W_));
  if (!(h.z() > kMinDepth)) return {};
  return h.hnormalized();
}

Eigen::Matrix<double, 2, 6> InverseDepthCamera::Sight::DerivativeByCamera(double rho) const {
  Eigen::Matrix<double, 2, 6> J;
  J << -rho * d_xy, d_xy * Hat(h);
  return J;
}

std::optional<InverseDepthProjection> LinearizeInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                            const Pose& X_WC) {
  const Eigen::Matrix3d R_A = X_WA.R();
  const InverseDepthCamera camera(X_WC);
  const auto sight = camera.See({R_A, X_WA.translation, xy, rho});
  if (!sight) return {};
  const Eigen::Matrix3d R_CA = camera.R_CW() * R_A;
  InverseDepthProjection out;
  out.xy = sight->xy;
  out.d_anchor << rho * sight->d_xy * R_CA, -sight->d_xy * R_CA * Hat(xy.homogeneous());
  out.d_camera = sight->DerivativeByCamera(rho);
  out.d_xy = sight->d_xy * R_CA.leftCols<2>();
  out.d_rho = sight->d_rho;
  return out;
}

double Mahalanobis2(const InverseDepthSighting& sighting, const InverseDepthCamera& camera) {
  const auto sight = camera.See(AnchoredPoint(sighting.point));
  if (!sight) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d e = sight->xy - sighting.xy;
  return e.dot(Covariance(sighting, sight->d_rho).inverse() * e);
}

double Mahalanobis2(const InverseDepthSighting& sighting, const Pose& X_WC) {
  return Mahalanobis2(sighting, InverseDepthCamera(X_WC));
}

namespace {

/// @param solve the change of the pose by the normal equations of all six freedoms
template <class Solve>
Pose Refine(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
            double huber, const std::optional<PositionPrior>& prior, Solve solve) {
  Pose pose = X_WC;
  const auto guesses =
      std::count_if(use.begin(), use.end(), [&](int i) { return sightings[size_t(i)].point.is_guess; });
  constexpr int kMaxSteps = 10;
  constexpr double kConverged = 1e-6, kMaxTurn = 0.5;  // rad; the linearisation holds no further
  std::vector<AnchoredPoint> points;
  points.reserve(use.size());
  for (const int i : use) points.emplace_back(sightings[size_t(i)].point);
  for (int step = 0; step < kMaxSteps; ++step) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    const InverseDepthCamera camera(pose);
    for (size_t k = 0; k < use.size(); ++k) {
      const InverseDepthSighting& sighting = sightings[size_t(use[k])];
      const auto sight = camera.See(points[k]);
      if (!sight) continue;
      const Eigen::Matrix2d information = Covariance(sighting, sight->d_rho, double(guesses)).inverse();
      const Eigen::Vector2d e = sight->xy - sighting.xy;
      const double distance = std::sqrt(e.dot(information * e));
      const double weight = distance > huber ? huber / distance : 1.0;
      const Eigen::Matrix<double, 2, 6> J = sight->DerivativeByCamera(points[k].rho);
      const Eigen::Matrix<double, 6, 2> weighted = weight * J.transpose() * information;
      H += weighted * J;
      g += weighted * e;
    }
    if (prior) {
      const double information = 1 / (prior->sigma * prior->sigma);
      H.topLeftCorner<3, 3>() += information * Eigen::Matrix3d::Identity();
      g.head<3>() += information * (pose.rotation.conjugate() * (pose.translation - prior->position_W));
    }
    // Where all points are at infinity the translation is not observed: damping keeps it where it is.
    H.topLeftCorner<3, 3>() += 1e-9 * (1 + H.bottomRightCorner<3, 3>().trace()) * Eigen::Matrix3d::Identity();
    const Vector6d change = -solve(H, g);
    if (!change.allFinite() || change.tail<3>().norm() > kMaxTurn) return step == 0 ? X_WC : pose;
    pose = Plus(pose, change);
    if (change.norm() < kConverged) break;
  }
  return pose;
}

}  // namespace

Pose RefinePose(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                double huber, const std::optional<PositionPrior>& prior) {
  return Refine(sightings, use, X_WC, huber, prior,
                [](const Matrix6d& H, const Vector6d& g) { return SolveSymmetric<6>(H, g); });
}

Pose RefinePosition(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                    double huber, const std::optional<PositionPrior>& prior) {
  return Refine(sightings, use, X_WC, huber, prior, [](const Matrix6d& H, const Vector6d& g) {
    Vector6d step = Vector6d::Zero();
    step.head<3>() = SolveSymmetric<3>(H.topLeftCorner<3, 3>(), g.head<3>());
    return step;
  });
}

TurnResult EstimateTurn(const std::vector<InverseDepthSighting>& sightings, const PositionPrior& prior,
                        const Eigen::Quaterniond& guess, double field, RandomStream& random) {
  TurnResult result{Pose(guess, prior.position_W), {}};
  const std::vector<DirectionPair> pairs = DirectionPairs(sightings, prior, field);
  const int n = int(pairs.size());
  if (n < 3) return result;
  std::vector<double> rest(pairs.size() + 1, 0.0);  // what those from each on can gain at most, rounding included
  constexpr double kRounding = 1e-9;
  for (size_t i = pairs.size(); i-- > 0;) rest[i] = rest[i + 1] + (1 + kRounding) * pairs[i].gain;
  double best_gain = -1;
  const auto judge = [&](const Eigen::Matrix3d& R_WC) {  // stops where it is clear that another is better
    double gain = 0;
    for (size_t i = 0; i < pairs.size() && (1 + kRounding) * gain + rest[i] >= best_gain; ++i) {
      gain += pairs[i].Gain(R_WC);
    }
    return gain;
  };
  Eigen::Matrix3d best = guess.toRotationMatrix();
  best_gain = judge(best);
  constexpr int kSamples = 1000;      // most are rejected at once: their angles differ
  constexpr double kWork = 100000.0;  // sightings judged in all
  int judged = 0;
  for (int k = 0; k < kSamples && judged * n < kWork; ++k) {
    const std::vector<int> two = internal::DrawSample(n, 2, random);
    const auto R_WC = TurnOfTwo(pairs[size_t(two[0])], pairs[size_t(two[1])]);
    if (!R_WC) continue;
    ++judged;
    const double gain = judge(*R_WC);
    if (gain <= best_gain) continue;
    best_gain = gain;
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
