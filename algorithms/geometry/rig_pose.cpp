#include "algorithms/geometry/rig_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "algorithms/geometry/absolute_pose.h"
#include "algorithms/geometry/ransac.h"
#include "algorithms/geometry/rig_projection.h"
#include "algorithms/geometry/robust_loss.h"

namespace gaitcam {
namespace {

/// Both images of a sighting, or the left one; whitened together with the point's error.
struct LinearSighting {
  int rows = 0;                         ///< 2 or 4.
  Eigen::Vector4d residual;             ///< In standard deviations.
  Eigen::Matrix<double, 4, 6> J;        ///< Whitened, by the tangent.
  Eigen::Matrix<double, 4, 3> J_point;  ///< Likewise, by p_W.
  Eigen::Matrix4d whitened_covariance;  ///< Of the images alone, after the whitening.
  double error2 = 0;
};

template <int N>
void Whiten(const Eigen::Matrix<double, N, N>& of_images, const RigSighting& sighting, LinearSighting& linear) {
  const Eigen::Matrix<double, N, 3> J_point = linear.J_point.topRows<N>();
  const Eigen::Matrix<double, N, N> W = Whitening<N>(of_images + J_point * sighting.covariance_W * J_point.transpose());
  linear.rows = N;
  linear.residual.head<N>() = (W * linear.residual.head<N>()).eval();
  linear.J.topRows<N>() = (W * linear.J.topRows<N>()).eval();
  linear.J_point.topRows<N>() = W * J_point;
  linear.whitened_covariance.topLeftCorner<N, N>() = W * of_images * W.transpose();
  linear.error2 = linear.residual.head<N>().squaredNorm();
}

/// @returns nothing for a point behind a camera.
std::optional<LinearSighting> Linearize(const RigSighting& sighting, const Pose& X_CW, const Pose& X_RL,
                                        bool use_right) {
  const auto left = ProjectInRig(X_CW, nullptr, sighting.p_W);
  if (!left) return {};
  LinearSighting linear;
  linear.residual.head<2>() = left->xy - sighting.left;
  linear.J.topRows<2>() = left->by_camera;
  linear.J_point.topRows<2>() = left->by_point;
  if (!use_right) {
    Whiten<2>(sighting.covariance_left, sighting, linear);
    return linear;
  }
  const auto right = ProjectInRig(X_CW, &X_RL, sighting.p_W);
  if (!right) return {};
  linear.residual.tail<2>() = right->xy - sighting.right;
  linear.J.bottomRows<2>() = right->by_camera;
  linear.J_point.bottomRows<2>() = right->by_point;
  Eigen::Matrix4d of_images = Eigen::Matrix4d::Zero();
  of_images.topLeftCorner<2, 2>() = sighting.covariance_left;
  of_images.bottomRightCorner<2, 2>() = sighting.covariance_right;
  Whiten<4>(of_images, sighting, linear);
  return linear;
}

/// The squared length of `rows` unit normals that is as rare as `sigmas` of one (Wilson and Hilferty's approximation of
/// the chi-square quantile, 1931).
double ErrorLimit2(double sigmas, int rows) {
  const double n = rows, tail = std::erfc(sigmas / std::sqrt(2.0));
  // Normal quantile of the same two-sided tail, taken one-sided.
  double low = 0, high = 40;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / std::sqrt(2.0)) > tail ? low : high) = middle;
  }
  return n * std::pow(1 - 2 / (9 * n) + low * std::sqrt(2 / (9 * n)), 3);
}

/// Gauss-Newton over the sightings that agree, and a prior.
class RigPoseProblem {
 public:
  RigPoseProblem(const std::vector<RigSighting>& sightings, const Pose& X_LR, const RigPosePrior& prior,
                 const RigPoseOptions& options)
      : sightings_(sightings),
        prior_(prior),
        X_RL_(X_LR.Inverse()),
        options_(options),
        limit2_{ErrorLimit2(options.outlier_sigmas, 2), ErrorLimit2(options.outlier_sigmas, 4)},
        huber_{std::sqrt(ErrorLimit2(options.huber, 2)), std::sqrt(ErrorLimit2(options.huber, 4))} {}

  /// A sighting whose images do not agree together may agree in the left one.
  std::vector<SightingUse> Choose(const Pose& X_WC) const {
    const Pose X_CW = X_WC.Inverse();
    std::vector<SightingUse> use;
    for (const RigSighting& sighting : sightings_) {
      const auto both = sighting.has_right ? Linearize(sighting, X_CW, X_RL_, true) : std::nullopt;
      const auto left = Linearize(sighting, X_CW, X_RL_, false);
      use.push_back(both && both->error2 < limit2_[1]   ? SightingUse::kBoth
                    : left && left->error2 < limit2_[0] ? SightingUse::kLeft
                                                        : SightingUse::kNone);
    }
    return use;
  }

  /// @returns false where the pose is not determined.
  bool Refine(const std::vector<SightingUse>& use, Pose& X_WC) const {
    constexpr int kIterations = 8;
    constexpr double kConverged = 1e-10;
    for (int i = 0; i < kIterations; ++i) {
      Matrix6d H = PriorInformation();
      Vector6d g = H * Minus(X_WC, prior_.X_WC);
      ForEach(use, X_WC, [&](size_t, const LinearSighting& linear, double weight) {
        const auto J = linear.J.topRows(linear.rows);
        H += weight * J.transpose() * J;
        g += weight * J.transpose() * linear.residual.head(linear.rows);
      });
      const Eigen::LLT<Matrix6d> factors(H);
      if (factors.info() != Eigen::Success) return false;
      const Vector6d step = -factors.solve(g);
      if (!step.allFinite()) return false;
      X_WC = Plus(X_WC, step);
      if (step.squaredNorm() < kConverged * kConverged) break;
    }
    return true;
  }

  /// At a minimum: tau = -H^-1 J' r of first order, r being the errors of images and points.
  std::optional<RigPoseResult> Describe(const std::vector<SightingUse>& use, const Pose& X_WC) const {
    RigPoseResult result;
    result.X_WC = X_WC;
    result.use = use;
    result.by_point.assign(use.size(), Eigen::Matrix<double, 6, 3>::Zero());
    Matrix6d H = PriorInformation(), own = H;
    std::map<std::pair<int, int>, Vector6d> cells;  // sum of J' r of each
    double error2 = 0;
    int rows = 0;
    ForEach(use, X_WC, [&](size_t i, const LinearSighting& linear, double weight) {
      const auto J = linear.J.topRows(linear.rows);
      H += weight * J.transpose() * J;
      own += weight * weight * J.transpose() * linear.whitened_covariance.topLeftCorner(linear.rows, linear.rows) * J;
      result.by_point[i] = -weight * J.transpose() * linear.J_point.topRows(linear.rows);
      const Eigen::Vector2d& at = sightings_[i].left;
      const std::pair cell(int(std::floor(at.x() / options_.cell)), int(std::floor(at.y() / options_.cell)));
      cells.try_emplace(cell, Vector6d::Zero()).first->second +=
          weight * J.transpose() * linear.residual.head(linear.rows);
      error2 += linear.error2;
      rows += linear.rows;
      ++result.inliers;
    });
    const Eigen::LLT<Matrix6d> factors(H);
    if (factors.info() != Eigen::Success || rows <= 6) return {};
    const Matrix6d inverse = factors.solve(Matrix6d::Identity());
    if (!inverse.allFinite()) return {};
    result.covariance_own = inverse * own * inverse;
    result.covariance = result.covariance_own;
    Matrix6d by_cell = Matrix6d::Zero();
    for (const auto& [cell, sum] : cells) by_cell += sum * sum.transpose();
    // The fit has taken six numbers from the residuals, and so few cells say little: an inverse of 7 fewer is unbiased.
    const double count = double(cells.size());
    result.covariance_by_residuals =
        count / std::max(1.0, count - 7) * (inverse * by_cell * inverse) + inverse * PriorInformation() * inverse;
    for (size_t i = 0; i < use.size(); ++i) {
      if (use[i] == SightingUse::kNone) continue;
      result.by_point[i] = (inverse * result.by_point[i]).eval();
      result.covariance += result.by_point[i] * sightings_[i].covariance_W * result.by_point[i].transpose();
    }
    result.mean_error2 = error2 / rows;
    return result;
  }

 private:
  template <class Visit>
  void ForEach(const std::vector<SightingUse>& use, const Pose& X_WC, Visit visit) const {
    const Pose X_CW = X_WC.Inverse();
    for (size_t i = 0; i < use.size(); ++i) {
      if (use[i] == SightingUse::kNone) continue;
      const bool both = use[i] == SightingUse::kBoth;
      const auto linear = Linearize(sightings_[i], X_CW, X_RL_, both);
      if (linear) visit(i, *linear, HuberLoss(linear->error2, huber_[both]).weight);
    }
  }

  Matrix6d PriorInformation() const {
    Vector6d sigmas;
    sigmas << Eigen::Vector3d::Constant(prior_.sigma_m), Eigen::Vector3d::Constant(prior_.sigma_rad);
    return sigmas.array().square().inverse().matrix().asDiagonal();
  }

  const std::vector<RigSighting>& sightings_;
  RigPosePrior prior_;
  Pose X_RL_;
  RigPoseOptions options_;
  double limit2_[2], huber_[2];  ///< Of the left image; of both.
};

int CountUsed(const std::vector<SightingUse>& use) {
  return int(std::count_if(use.begin(), use.end(), [](SightingUse u) { return u != SightingUse::kNone; }));
}

}  // namespace

std::optional<RigPoseResult> RefineRigPose(const std::vector<RigSighting>& sightings, const Pose& X_LR,
                                           const Pose& guess, const RigPosePrior& prior, int min_inliers,
                                           const RigPoseOptions& options) {
  const RigPoseProblem problem(sightings, X_LR, prior, options);
  Pose X_WC = guess;
  std::vector<SightingUse> use;
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<SightingUse> next = problem.Choose(X_WC);
    if (CountUsed(next) < min_inliers) return {};
    if (next == use) break;
    use = std::move(next);
    if (!problem.Refine(use, X_WC)) return {};
  }
  return problem.Describe(use, X_WC);
}

std::optional<RigPoseResult> EstimateRigPose(const std::vector<RigSighting>& sightings, const Pose& X_LR,
                                             const RigPosePrior& prior, int min_inliers, const RigPoseOptions& options,
                                             RandomStream& random) {
  if (int(sightings.size()) < min_inliers) return {};
  const Pose guess_CW = prior.X_WC.Inverse();
  std::vector<PointSighting> seen;
  std::vector<Eigen::Matrix2d> whiten;
  for (const RigSighting& sighting : sightings) {
    seen.push_back({sighting.p_W, sighting.left});
    Eigen::Matrix2d covariance = sighting.covariance_left;
    if (const auto image = ProjectInRig(guess_CW, nullptr, sighting.p_W)) {
      covariance += image->by_point * sighting.covariance_W * image->by_point.transpose();
    }
    whiten.push_back(Whitening(covariance));
  }
  const auto solve = [&](const std::vector<int>& three) {
    constexpr double kMostSigmas = 4;
    std::vector<Pose> poses = SolveThreePoint({seen[size_t(three[0])], seen[size_t(three[1])], seen[size_t(three[2])]});
    std::erase_if(poses, [&](const Pose& X) { return prior.Deviation(X).cwiseAbs().maxCoeff() > kMostSigmas; });
    return poses;
  };
  const auto error2 = [&](const Pose& X_WC, int i) {
    const Eigen::Vector3d p_C = X_WC.rotation.conjugate() * (seen[size_t(i)].p_W - X_WC.translation);
    if (p_C.z() <= kLeastDepth) return std::numeric_limits<double>::infinity();
    return (whiten[size_t(i)] * (p_C.hnormalized() - seen[size_t(i)].xy)).squaredNorm();
  };
  constexpr double kConfidence = 0.999;
  const RansacOptions robustly{options.ransac_sigmas, kConfidence, options.ransac_samples, 5};
  const auto found = Ransac<Pose>(int(seen.size()), 3, robustly, random, solve, error2, {prior.X_WC});
  if (int(found.inliers.size()) < min_inliers) return {};
  return RefineRigPose(sightings, X_LR, found.model, prior, min_inliers, options);
}

}  // namespace gaitcam
