#include "results/scoring/alignment.h"

#include <Eigen/LU>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

/// Below this root-mean-square extent a path counts as one point, m.
constexpr double kMinExtent_m = 1e-9;
/// A singular value of the covariance below this part of the largest does not determine a direction.
constexpr double kMinSingularRatio = 1e-10;

/// Means, variances and covariance of the paired positions (Umeyama's equations 34 to 38).
struct Moments {
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero(), mean_truth = Eigen::Vector3d::Zero();
  double variance_estimate = 0, variance_truth = 0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();    ///< E[(truth - mean) (estimate - mean)^T]
  Eigen::Matrix3d rotation_sum = Eigen::Matrix3d::Zero();  ///< Sum of R_WC R_VC^T: what the orientations say of R_WV.

  explicit Moments(const std::vector<PosePair>& pairs) {
    const double n = double(pairs.size());
    for (const PosePair& p : pairs) {
      mean_estimate += p.estimate.translation / n;
      mean_truth += p.truth.translation / n;
    }
    for (const PosePair& p : pairs) {
      const Eigen::Vector3d e = p.estimate.translation - mean_estimate, t = p.truth.translation - mean_truth;
      variance_estimate += e.squaredNorm() / n;
      variance_truth += t.squaredNorm() / n;
      covariance += t * e.transpose() / n;
      rotation_sum += p.truth.R() * p.estimate.R().transpose();
    }
  }
  bool BothExtend() const {
    return std::sqrt(variance_estimate) > kMinExtent_m && std::sqrt(variance_truth) > kMinExtent_m;
  }
};

/// The rotation about unit `axis` that, put before R, agrees best with the orientations: it maximises
/// tr(exp(angle [axis]) R sum(R_VC R_WC^T)), which Rodrigues' formula turns into a cos + b sin + c.
Eigen::Matrix3d TurnAboutAxis(const Eigen::Vector3d& axis, const Eigen::Matrix3d& R,
                              const Eigen::Matrix3d& rotation_sum) {
  const Eigen::Matrix3d m = R * rotation_sum.transpose();
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double along = axis.dot(m * axis);
  const double angle = std::atan2((cross * m).trace(), m.trace() - along);
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix() * R;
}

void AlignRotation(const Moments& moments, bool with_scale, AlignmentResult& result) {
  if (!moments.BothExtend()) {
    result.rank = 0;
    result.scale_known = false;
    result.X_WV.rotation = SvdOf(moments.rotation_sum).NearestRotation();
    return;
  }
  const Svd3 svd = SvdOf(moments.covariance);
  const Eigen::Vector3d& d = svd.values;
  result.rank = int((d.array() > kMinSingularRatio * d(0)).count());
  Eigen::Matrix3d R = svd.NearestRotation();
  if (result.rank < 2) R = TurnAboutAxis(svd.U.col(0), R, moments.rotation_sum);
  result.X_WV.rotation = Eigen::Quaterniond(R).normalized();
  const Eigen::Vector3d s(1, 1, svd.Handedness());
  if (with_scale) result.X_WV.scale = d.dot(s) / moments.variance_estimate;  // equation 42
}

void AlignYaw(const Moments& moments, AlignmentResult& result) {
  const Eigen::Matrix3d& c = moments.covariance;
  const double along = c(0, 0) + c(1, 1), across = c(1, 0) - c(0, 1);  // sums of x.x' and of x cross x'
  const double horizontal = std::hypot(along, across);
  Eigen::Matrix3d R;
  if (horizontal > kMinExtent_m * kMinExtent_m) {
    R = Eigen::AngleAxisd(std::atan2(across, along), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  } else {
    result.rank = 0;
    R = TurnAboutAxis(Eigen::Vector3d::UnitZ(), Eigen::Matrix3d::Identity(), moments.rotation_sum);
  }
  result.X_WV.rotation = R;
}

}  // namespace

std::string ToString(Alignment alignment) {
  switch (alignment) {
    case Alignment::kNone: return "none";
    case Alignment::kSe3: return "se3";
    case Alignment::kSim3: return "sim3";
    case Alignment::kYaw: return "yaw";
  }
  GAITCAM_ASSERT(false);
  return {};
}

Pose Similarity::operator*(const Pose& pose) const { return {rotation * pose.rotation, *this * pose.translation}; }

std::string AlignmentResult::Remark() const {
  if (rank == 0)
    return "positions do not extend: rotation taken from the orientations" +
           std::string(scale_known ? "" : ", scale kept at 1");
  if (rank == 1) return "positions lie on a line: rotation about it taken from the orientations";
  return {};
}

AlignmentResult Align(const std::vector<PosePair>& pairs, Alignment alignment) {
  GAITCAM_ASSERT(!pairs.empty());
  AlignmentResult result;
  if (alignment == Alignment::kNone) return result;
  const Moments moments(pairs);
  if (alignment == Alignment::kYaw) {
    AlignYaw(moments, result);
  } else {
    AlignRotation(moments, alignment == Alignment::kSim3, result);
  }
  Similarity& X = result.X_WV;
  X.translation = moments.mean_truth - X.scale * (X.rotation * moments.mean_estimate);  // equation 41
  return result;
}

Eigen::Quaterniond AlignOrientations(const std::vector<PosePair>& pairs) {
  GAITCAM_ASSERT(!pairs.empty());
  return Eigen::Quaterniond(SvdOf(Moments(pairs).rotation_sum).NearestRotation()).normalized();
}

std::vector<PosePair> Apply(const Similarity& X_WV, std::vector<PosePair> pairs) {
  for (PosePair& p : pairs) p.estimate = X_WV * p.estimate;
  return pairs;
}

}  // namespace gaitcam
