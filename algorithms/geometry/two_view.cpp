#include "algorithms/geometry/two_view.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/geometry/homography.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"

namespace gaitcam {
namespace {

constexpr size_t kFewestPairs = 8;  // five determine the pose; three more to tell a pose from chance

/// Normal equations of the inliers' Sampson errors in (turn w of R exp(w), t along its two tangents); the errors'
/// denominators are held fixed.
struct NormalEquations {
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
  double error2 = 0;
  Eigen::Vector3d u, v;  ///< Tangents of the sphere of directions at t.

  NormalEquations(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const RelativeMotion& motion)
      : u(motion.t.unitOrthogonal()), v(motion.t.cross(u)) {
    const Eigen::Matrix3d E = motion.E();
    std::vector<Eigen::Matrix3d> derivative;
    for (int k = 0; k < 3; ++k) derivative.push_back(E * CrossMatrix(Eigen::Vector3d::Unit(k)));
    derivative.push_back(CrossMatrix(u) * motion.R);
    derivative.push_back(CrossMatrix(v) * motion.R);
    for (const int i : inliers) {
      const Eigen::Vector3d a = pairs[size_t(i)].a.homogeneous(), b = pairs[size_t(i)].b.homogeneous();
      const Eigen::Vector3d Ea = E * a, Etb = E.transpose() * b;
      const double weight = 1 / std::max(Ea.head<2>().squaredNorm() + Etb.head<2>().squaredNorm(), 1e-12);
      Eigen::Matrix<double, 5, 1> J;
      for (int k = 0; k < 5; ++k) J[k] = b.dot(derivative[size_t(k)] * a);
      H += weight * J * J.transpose();
      g += weight * J * b.dot(Ea);
      error2 += weight * b.dot(Ea) * b.dot(Ea);
    }
  }
};

/// One Gauss-Newton step.
void Refine(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, RelativeMotion& motion) {
  const NormalEquations equations(pairs, inliers, motion);
  const Eigen::Matrix<double, 5, 1> step = -equations.H.ldlt().solve(equations.g);
  constexpr double kLargestStep = 0.2;  // beyond it (rad) the linearisation is worthless
  if (!step.allFinite() || step.norm() > kLargestStep) return;
  const Eigen::Vector3d w = step.head<3>();
  if (w.norm() > 0) motion.R = motion.R * Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  motion.t = (motion.t + step[3] * equations.u + step[4] * equations.v).normalized();
}

/// Of the direction of X_AB's translation, d = -R^T t: the covariance sigma^2 H^-1 of turn and t, propagated to d.
double DirectionSigma(const std::vector<PointPair>& pairs, const std::vector<int>& inliers,
                      const RelativeMotion& motion) {
  const NormalEquations equations(pairs, inliers, motion);
  const double sigma2 = equations.error2 / double(inliers.size() - 5);
  const Eigen::Matrix<double, 5, 5> covariance = sigma2 * equations.H.inverse();
  if (!covariance.allFinite()) return M_PI;
  Eigen::Matrix<double, 3, 5> J;  // (R exp(w))^T t = R^T t - w x R^T t to first order
  J << CrossMatrix(motion.R.transpose() * motion.t), motion.R.transpose() * equations.u,
      motion.R.transpose() * equations.v;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(J * covariance * J.transpose());
  const double largest = eigen.eigenvalues()[2];
  return largest >= 0 ? std::min(M_PI, std::sqrt(largest)) : M_PI;
}

std::vector<int> InliersInFront(const std::vector<PointPair>& pairs, const RelativeMotion& motion, double threshold) {
  std::vector<int> inliers;
  const Eigen::Matrix3d E = motion.E();
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (SampsonError2(E, pairs[i]) < threshold * threshold && InFront(motion, pairs[i])) inliers.push_back(int(i));
  }
  return inliers;
}

/// Sum over all pairs of min(Sampson error^2, threshold^2), points behind a camera counting in full.
double Score(const std::vector<PointPair>& pairs, const RelativeMotion& motion, double threshold) {
  const Eigen::Matrix3d E = motion.E();
  const double limit2 = threshold * threshold;
  double score = 0;
  for (const PointPair& pair : pairs) {
    const double error2 = SampsonError2(E, pair);
    score += error2 < limit2 && InFront(motion, pair) ? error2 : limit2;
  }
  return score;
}

struct ScoredMotion {
  RelativeMotion motion;
  double score;
};

/// Descends from `start`, then chooses again among the four decompositions.
ScoredMotion Descend(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, RelativeMotion start,
                     double threshold) {
  constexpr int kSteps = 8;
  for (int step = 0; step < kSteps; ++step) Refine(pairs, inliers, start);
  const RelativeMotion chosen = ChooseByDepth(start.E(), pairs, inliers);
  return {chosen, Score(pairs, chosen, threshold)};
}

/// Small motions leave the two-view error with several minima, of which some trade a sideways motion for a turn
/// (Chiuso, Brockett and Soatto, IJCV 2000), and views of a plane have two. So descends from the robust answer, from
/// its rotation with each axis as direction, and from what the inliers' homography allows. Lowest score first.
std::vector<ScoredMotion> RefineFromSeveral(const std::vector<PointPair>& pairs, const std::vector<int>& inliers,
                                            const RelativeMotion& found, const std::optional<Eigen::Matrix3d>& H,
                                            double threshold) {
  std::vector<RelativeMotion> starts = {found};
  for (const Eigen::Matrix3d& R : {found.R, RotationAlone(pairs, inliers)}) {
    for (int axis = 0; axis < 3; ++axis) starts.push_back({R, Eigen::Vector3d::Unit(axis)});
  }
  if (H) {
    for (const PlaneMotion& motion : DecomposeHomography(*H)) {
      if (motion.t.norm() > 0 && motion.normal.z() > 0) starts.push_back({motion.R, motion.t.normalized()});
    }
  }
  std::vector<ScoredMotion> refined;
  for (const RelativeMotion& start : starts) refined.push_back(Descend(pairs, inliers, start, threshold));
  std::stable_sort(refined.begin(), refined.end(),
                   [](const ScoredMotion& a, const ScoredMotion& b) { return a.score < b.score; });
  return refined;
}

/// Torr's geometric robust information criterion: smaller is the better model of `n` pairs.
/// @param dimension  of the manifold a model confines a pair (4 numbers) to
/// @param parameters of the model
template <class Error2>
double Gric(const std::vector<int>& use, double sigma2, int dimension, int parameters, Error2 error2) {
  const double limit = 2.0 * (4 - dimension), n = double(use.size());
  double sum = std::log(4.0) * dimension * n + std::log(4.0 * n) * parameters;
  for (const int i : use) sum += std::min(error2(i) / sigma2, limit);
  return sum;
}

/// Is it a turn alone, or a plane? Errors are weighed with the noise that the general model leaves.
void Judge(const std::vector<PointPair>& pairs, const RelativeMotion& motion, const std::optional<Eigen::Matrix3d>& H,
           TwoView& result) {
  const std::vector<int>& use = result.inliers;
  const Eigen::Matrix3d E = motion.E(), R = RotationAlone(pairs, use);
  double sigma2 = 0;
  for (const int i : use) sigma2 += SampsonError2(E, pairs[size_t(i)]) / double(use.size() - 5);
  sigma2 = std::max(sigma2, 1e-16);
  // A transfer error lives in one image: half of its square is what both images' errors would have to be.
  const double general = Gric(use, sigma2, 3, 5, [&](int i) { return SampsonError2(E, pairs[size_t(i)]); });
  const double turn = Gric(use, sigma2, 2, 3, [&](int i) { return TransferError2(R, pairs[size_t(i)]) / 2; });
  result.rotation_only = turn < general;
  if (H) {
    const double plane = Gric(use, sigma2, 2, 8, [&](int i) { return TransferError2(*H, pairs[size_t(i)]) / 2; });
    result.planar = !result.rotation_only && plane < general;
  }
}

double MedianParallax(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const Eigen::Matrix3d& R) {
  std::vector<double> angles;
  for (const int i : inliers) {
    const Eigen::Vector3d a = R * pairs[size_t(i)].a.homogeneous(), b = pairs[size_t(i)].b.homogeneous();
    angles.push_back(std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  std::nth_element(angles.begin(), angles.begin() + long(angles.size() / 2), angles.end());
  return angles[angles.size() / 2];
}

}  // namespace

RansacResult<Eigen::Matrix3d> EstimateEssential(const std::vector<PointPair>& pairs, const RansacOptions& options,
                                                RandomStream& random,
                                                double (*error2)(const Eigen::Matrix3d&, const PointPair&)) {
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<PointPair> five;
    for (const int i : sample) five.push_back(pairs[size_t(i)]);
    return SolveFivePoint(five);
  };
  const auto residual2 = [&](const Eigen::Matrix3d& E, int i) { return error2(E, pairs[size_t(i)]); };
  return EstimateRobustly<Eigen::Matrix3d>(int(pairs.size()), 5, options, random, solve, residual2);
}

TwoView RefineTwoView(const std::vector<PointPair>& pairs, const Eigen::Matrix3d& E, const std::vector<int>& found,
                      double threshold) {
  TwoView result;
  result.X_AB.translation = Eigen::Vector3d::UnitX();
  if (found.size() < kFewestPairs) return result;
  const std::optional<Eigen::Matrix3d> H = EstimateHomography(pairs, found);
  const std::vector<ScoredMotion> refined =
      RefineFromSeveral(pairs, found, ChooseByDepth(E, pairs, found), H, threshold);
  const RelativeMotion& motion = refined.front().motion;
  std::vector<int> inliers = InliersInFront(pairs, motion, threshold);
  if (inliers.size() < kFewestPairs) return result;
  result.X_AB = Pose(motion.R, motion.t).Inverse();
  result.direction_sigma = DirectionSigma(pairs, inliers, motion);
  result.parallax = MedianParallax(pairs, inliers, motion.R);
  result.inliers = std::move(inliers);
  Judge(pairs, motion, H, result);
  constexpr double kDifferent = 0.05;   // rad, of the direction: another pose, not the same minimum again
  constexpr double kAboutAsGood = 1.2;  // scores are sums of squares: 1.1 times the residual
  for (const ScoredMotion& other : refined) {
    const bool different = std::acos(std::clamp(other.motion.t.dot(motion.t), -1.0, 1.0)) > kDifferent;
    if (!result.planar || !different || other.score > kAboutAsGood * refined.front().score) continue;
    result.alternative = Pose(other.motion.R, other.motion.t).Inverse();
    break;
  }
  return result;
}

TwoView EstimateTwoView(const std::vector<PointPair>& pairs, const RansacOptions& options, RandomStream& random) {
  if (pairs.size() < kFewestPairs) return RefineTwoView(pairs, Eigen::Matrix3d::Identity(), {}, options.threshold);
  const auto found = EstimateEssential(pairs, options, random, SampsonError2);
  return RefineTwoView(pairs, found.model, found.inliers, options.threshold);
}

}  // namespace gaitcam
