/// The motion between two clouds of matched points.
///
/// Source: Valencia, section 2.2. Cloud A is the chapter's first, B its second: p_A = X_AB p_B (Eq. 2.4).
///
/// Two remarks on the chapter's Horn. The matrix of Eq. 2.9 belongs to quaternions (w, x, y, z), while Eqs. 2.11 and
/// 2.12 read its eigenvector as (x, y, z, w): the first is right. And directions from the camera (Eqs. 2.5 and 2.6)
/// turn by the camera's translation too, so that Eq. 2.7 over them is exact for rotations alone; Horn's own method has
/// points over their centroids instead, and minimises Eq. 2.4.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {

/// A point in two frames, m, and how well it is known in each, m^2. Errors in A and B are independent.
struct PointMatch {
  Eigen::Vector3d p_A, p_B;
  Eigen::Matrix3d covariance_A = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance_B = Eigen::Matrix3d::Identity();
};

enum class RigidMotionMethod {
  kHornDirections,     ///< Eqs. 2.5 to 2.14: by quaternion over directions from the origin.
  kHorn,               ///< The same over points about their centroids.
  kSvd,                ///< Eqs. 2.15 to 2.21. The same minimum.
  kMaximumLikelihood,  ///< From kSvd on, points weighted with their covariances.
};
constexpr auto WordsOf(RigidMotionMethod) {
  return std::array{EnumWord{RigidMotionMethod::kHornDirections, "horn_directions"},
                    EnumWord{RigidMotionMethod::kHorn, "horn"}, EnumWord{RigidMotionMethod::kSvd, "svd"},
                    EnumWord{RigidMotionMethod::kMaximumLikelihood, "maximum_likelihood"}};
}

enum class RigidMotionStatus {
  kOk,
  kTooFew,       ///< Fewer than 3 points.
  kNotFinite,    ///< A coordinate or a covariance is not finite.
  kPoint,        ///< All points of a cloud are one: no rotation follows.
  kLine,         ///< All points of a cloud lie on a line: the rotation about it is free.
  kNoConsensus,  ///< No motion has enough inliers.
};
constexpr auto WordsOf(RigidMotionStatus) {
  return std::array{EnumWord{RigidMotionStatus::kOk, "ok"},
                    EnumWord{RigidMotionStatus::kTooFew, "too_few"},
                    EnumWord{RigidMotionStatus::kNotFinite, "not_finite"},
                    EnumWord{RigidMotionStatus::kPoint, "point"},
                    EnumWord{RigidMotionStatus::kLine, "line"},
                    EnumWord{RigidMotionStatus::kNoConsensus, "no_consensus"}};
}

struct RigidMotion {
  RigidMotionStatus status = RigidMotionStatus::kTooFew;
  Pose X_AB;               ///< The identity unless the status is kOk.
  bool reflected = false;  ///< A reflection would fit better: mirrored axes, or points of one plane with noise.

  bool ok() const { return status == RigidMotionStatus::kOk; }
};

/// What in a cloud of matches prevents a rotation from following, else kOk. Extents count as none below 1e-6 of the
/// cloud's largest, or of its distance: rounding, not noise; what noise leaves free is in the covariance.
RigidMotionStatus Degeneracy(const std::vector<PointMatch>& matches);

/// The motion that fits all matches best. Only kMaximumLikelihood reads covariances.
RigidMotion FitRigidMotion(const std::vector<PointMatch>& matches, RigidMotionMethod method);

/// e = p_A - X_AB p_B and its covariance S = S_A + R S_B R^T.
struct MatchError {
  Eigen::Vector3d e;
  Eigen::Matrix3d covariance;

  MatchError(const PointMatch& match, const Pose& X_AB);
  /// e^T S^-1 e: chi-square of three degrees of freedom for a right match and motion; infinity if it is not finite.
  double Squared() const;
};

/// The minimum of the sum of MatchError::Squared() with covariances as they are at the motion (Matthies and Shafer,
/// IEEE J. Robot. Autom. 3, 1987), by Gauss-Newton.
struct LikelyMotion {
  Pose X_AB;
  Matrix6d covariance;  ///< Of X_AB, in the tangent of se3.h: inverse of the information. NaN if it is singular.
  double cost = 0;      ///< Chi-square of 3 n - 6 degrees of freedom, if covariances are right.
};
LikelyMotion RefineRigidMotion(const std::vector<PointMatch>& matches, const Pose& X_AB);

struct RigidMotionOptions {
  RigidMotionMethod method = RigidMotionMethod::kMaximumLikelihood;
  /// Threshold in standard deviations (kSigmas, below) or in m.
  RansacOptions ransac{.threshold = 3.0};
  /// Matches are judged by MatchError; false: by |e| in m, as the chapter has it, blind to what is far.
  bool by_sigmas = true;
  int min_inliers = 6;
};

struct RobustRigidMotion {
  RigidMotion motion;
  std::vector<int> inliers;  ///< Indices in increasing order.
};

/// RANSAC over samples of three matches, then `method` over the inliers, twice, as inliers change with it.
RobustRigidMotion EstimateRigidMotion(const std::vector<PointMatch>& matches, const RigidMotionOptions& options,
                                      RandomStream& random);

}  // namespace gaitcam
