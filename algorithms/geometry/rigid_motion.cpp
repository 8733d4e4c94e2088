#include "algorithms/geometry/rigid_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

struct Centroids {
  Eigen::Vector3d A = Eigen::Vector3d::Zero(), B = Eigen::Vector3d::Zero();

  explicit Centroids(const std::vector<PointMatch>& matches) {
    for (const PointMatch& match : matches) {
      A += match.p_A / double(matches.size());
      B += match.p_B / double(matches.size());
    }
  }
};

bool AllFinite(const PointMatch& match) {
  return match.p_A.allFinite() && match.p_B.allFinite() && match.covariance_A.allFinite() &&
         match.covariance_B.allFinite();
}

/// Of one cloud, by the scatter of its points; `far` is their mean square distance from the origin.
RigidMotionStatus DegeneracyOf(const Eigen::Matrix3d& scatter, double far) {
  constexpr double kNone2 = 1e-12;  // of mean square extents
  const Eigen::Vector3d extents2 = EigenOfSymmetric(scatter).values;
  if (!(extents2[2] > kNone2 * far)) return RigidMotionStatus::kPoint;
  return extents2[1] > kNone2 * std::max(extents2[2], kNone2 * far) ? RigidMotionStatus::kOk : RigidMotionStatus::kLine;
}

/// Eqs. 2.7 to 2.10 of the vectors b_i = v_2 + v_1 and c_i = v_2 - v_1 of matched vectors: the unit quaternion that
/// minimises sum |v_1 - q v_2 q*|^2. For it |v_1 - q v_2 q*| = |q v_2 - v_1 q| = |B_i q| with B_i of Eq. 2.9 and
/// q = (w, x, y, z); B_i is skew-symmetric, so that B_i B_i^T of Eq. 2.8 is B_i^T B_i.
class QuaternionSum {
 public:
  void Add(const Eigen::Vector3d& v1, const Eigen::Vector3d& v2) {
    const Eigen::Vector3d b = v2 + v1, c = v2 - v1;
    Eigen::Matrix4d B;
    B << 0, -c.x(), -c.y(), -c.z(),  //
        c.x(), 0, b.z(), -b.y(),     //
        c.y(), -b.z(), 0, b.x(),     //
        c.z(), b.y(), -b.x(), 0;
    sum_ += B * B.transpose();
  }
  Eigen::Quaterniond Best() const {
    const Eigen::Vector4d q = SmallestEigenvector(sum_);
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  }

 private:
  Eigen::Matrix4d sum_ = Eigen::Matrix4d::Zero();
};

Eigen::Quaterniond RotationByHorn(const std::vector<PointMatch>& matches, const Centroids& centroids, bool directions) {
  QuaternionSum sum;
  for (const PointMatch& match : matches) {
    if (directions) {
      sum.Add(match.p_A.normalized(), match.p_B.normalized());  // Eqs. 2.5 and 2.6
    } else {
      sum.Add(match.p_A - centroids.A, match.p_B - centroids.B);
    }
  }
  return sum.Best();
}

/// Eq. 2.18.
Eigen::Matrix3d CrossScatter(const std::vector<PointMatch>& matches, const Centroids& centroids) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const PointMatch& match : matches) M += (match.p_A - centroids.A) * (match.p_B - centroids.B).transpose();
  return M;
}

/// The inliers of a motion, and those matches.
std::pair<std::vector<int>, std::vector<PointMatch>> InliersOf(const std::vector<PointMatch>& matches,
                                                               const RigidMotionOptions& options, const Pose& X_AB) {
  const double limit2 = options.ransac.threshold * options.ransac.threshold;
  std::pair<std::vector<int>, std::vector<PointMatch>> inliers;
  for (int i = 0; i < int(matches.size()); ++i) {
    const MatchError error(matches[size_t(i)], X_AB);
    if ((options.by_sigmas ? error.Squared() : error.e.squaredNorm()) < limit2) {
      inliers.first.push_back(i);
      inliers.second.push_back(matches[size_t(i)]);
    }
  }
  return inliers;
}

}  // namespace

RigidMotionStatus Degeneracy(const std::vector<PointMatch>& matches) {
  constexpr size_t kMinPoints = 3;
  if (matches.size() < kMinPoints) return RigidMotionStatus::kTooFew;
  if (!std::all_of(matches.begin(), matches.end(), AllFinite)) return RigidMotionStatus::kNotFinite;
  const Centroids centroids(matches);
  Eigen::Matrix3d scatter_A = Eigen::Matrix3d::Zero(), scatter_B = Eigen::Matrix3d::Zero();
  double far_A = 0, far_B = 0;
  for (const PointMatch& match : matches) {
    const Eigen::Vector3d a = match.p_A - centroids.A, b = match.p_B - centroids.B;
    scatter_A += a * a.transpose();
    scatter_B += b * b.transpose();
    far_A += match.p_A.squaredNorm();
    far_B += match.p_B.squaredNorm();
  }
  const RigidMotionStatus status = DegeneracyOf(scatter_A, far_A);
  return status == RigidMotionStatus::kOk ? DegeneracyOf(scatter_B, far_B) : status;
}

RigidMotion FitRigidMotion(const std::vector<PointMatch>& matches, RigidMotionMethod method) {
  RigidMotion motion;
  motion.status = Degeneracy(matches);
  if (!motion.ok()) return motion;
  const Centroids centroids(matches);
  const Svd3 svd = SvdOf(CrossScatter(matches, centroids));
  motion.reflected = svd.Handedness() < 0;
  const bool horn = method == RigidMotionMethod::kHorn || method == RigidMotionMethod::kHornDirections;
  motion.X_AB.rotation = horn ? RotationByHorn(matches, centroids, method == RigidMotionMethod::kHornDirections)
                              : Eigen::Quaterniond(svd.NearestRotation()).normalized();  // Eq. 2.20
  motion.X_AB.translation = centroids.A - motion.X_AB.rotation * centroids.B;            // Eqs. 2.14 and 2.21
  if (method == RigidMotionMethod::kMaximumLikelihood) motion.X_AB = RefineRigidMotion(matches, motion.X_AB).X_AB;
  return motion;
}

MatchError::MatchError(const PointMatch& match, const Pose& X_AB) : e(match.p_A - X_AB * match.p_B) {
  const Eigen::Matrix3d R = X_AB.R();
  covariance = match.covariance_A + R * match.covariance_B * R.transpose();
}

double MatchError::Squared() const {
  const double squared = e.dot(SolveSymmetric<3>(covariance, e));
  return squared >= 0 ? squared : std::numeric_limits<double>::infinity();
}

LikelyMotion RefineRigidMotion(const std::vector<PointMatch>& matches, const Pose& X_AB) {
  constexpr int kSteps = 20;
  constexpr double kArrived = 1e-12;  // m and rad
  LikelyMotion result{X_AB, Matrix6d::Constant(std::numeric_limits<double>::quiet_NaN()), 0};
  Matrix6d information = Matrix6d::Zero();
  for (int step = 0; step < kSteps; ++step) {
    information.setZero();
    Vector6d gradient = Vector6d::Zero();
    result.cost = 0;
    const Eigen::Matrix3d R = result.X_AB.R();
    for (const PointMatch& match : matches) {
      const MatchError error(match, result.X_AB);
      const Eigen::Matrix3d W = InverseOfSymmetric<3>(error.covariance);
      Eigen::Matrix<double, 3, 6> J;  // of X Exp(tau) p_B by tau
      J << R, -R * Hat(match.p_B);
      information += J.transpose() * W * J;
      gradient += J.transpose() * W * error.e;
      result.cost += error.e.dot(W * error.e);
    }
    const Vector6d change = SolveSymmetric<6>(information, gradient);
    if (!change.allFinite()) return result;
    result.X_AB = Plus(result.X_AB, change);
    if (change.norm() < kArrived) break;
  }
  result.covariance = InverseOfSymmetric<6>(information);
  return result;
}

RobustRigidMotion EstimateRigidMotion(const std::vector<PointMatch>& matches, const RigidMotionOptions& options,
                                      RandomStream& random) {
  RobustRigidMotion result;
  constexpr int kSample = 3;
  if (int(matches.size()) < kSample) return result;
  if (!std::all_of(matches.begin(), matches.end(), AllFinite)) {
    result.motion.status = RigidMotionStatus::kNotFinite;
    return result;
  }
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<PointMatch> three;
    for (const int i : sample) three.push_back(matches[size_t(i)]);
    const RigidMotion motion = FitRigidMotion(three, RigidMotionMethod::kSvd);
    return motion.ok() ? std::vector<Pose>{motion.X_AB} : std::vector<Pose>{};
  };
  const auto residual2 = [&](const Pose& X_AB, int i) {
    const MatchError error(matches[size_t(i)], X_AB);
    return options.by_sigmas ? error.Squared() : error.e.squaredNorm();
  };
  const auto consensus = Ransac<Pose>(int(matches.size()), kSample, options.ransac, random, solve, residual2);
  result.motion.status = RigidMotionStatus::kNoConsensus;
  Pose X_AB = consensus.model;
  if (int(consensus.inliers.size()) < std::max(kSample, options.min_inliers)) {
    // All samples of a degenerate cloud are: it says so, rather than that none was found.
    const RigidMotionStatus status = Degeneracy(matches);
    if (status != RigidMotionStatus::kOk) result.motion.status = status;
    return result;
  }
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    const auto [inliers, matched] = InliersOf(matches, options, X_AB);
    if (int(inliers.size()) < std::max(kSample, options.min_inliers)) return {{RigidMotionStatus::kNoConsensus}, {}};
    result = {FitRigidMotion(matched, options.method), inliers};
    if (!result.motion.ok()) return result;
    X_AB = result.motion.X_AB;
  }
  return result;
}

}  // namespace gaitcam
