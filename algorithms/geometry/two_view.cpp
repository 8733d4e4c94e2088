#include "algorithms/geometry/two_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/median.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/small_solvers.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/homography.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"

namespace gaitcam {
namespace {

constexpr size_t kMinPairs = 8;  // five determine the pose; three more distinguish it from chance

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
    for (int k = 0; k < 3; ++k) derivative.push_back(E * Hat(Eigen::Vector3d::Unit(k)));
    derivative.push_back(Hat(u) * motion.R);
    derivative.push_back(Hat(v) * motion.R);
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
  const Eigen::Matrix<double, 5, 1> step = -SolveSymmetric<5>(equations.H, equations.g);
  constexpr double kMaxStep = 0.2;  // rad; the linearisation holds no further
  if (!step.allFinite() || step.norm() > kMaxStep) return;
  motion.R = motion.R * ExpSo3(step.head<3>()).toRotationMatrix();
  motion.t = (motion.t + step[3] * equations.u + step[4] * equations.v).normalized();
}

/// Of the direction of X_AB's translation, d = -R^T t: the covariance sigma^2 H^-1 of turn and t, propagated to d.
double DirectionSigma(const std::vector<PointPair>& pairs, const std::vector<int>& inliers,
                      const RelativeMotion& motion) {
  const NormalEquations equations(pairs, inliers, motion);
  const double sigma2 = equations.error2 / double(inliers.size() - 5);
  const Eigen::Matrix<double, 5, 5> covariance = sigma2 * Inverse(equations.H);
  if (!covariance.allFinite()) return M_PI;
  Eigen::Matrix<double, 3, 5> J;  // (R exp(w))^T t = R^T t - w x R^T t to first order
  J << Hat(motion.R.transpose() * motion.t), motion.R.transpose() * equations.u, motion.R.transpose() * equations.v;
  const Eigen::Matrix3d lower = (J * covariance * J.transpose()).triangularView<Eigen::Lower>();
  const double variance = EigenOfSymmetric(lower).values[2];
  return variance >= 0 ? std::min(M_PI, std::sqrt(variance)) : M_PI;
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
  double score = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Of the plane that allows it, towards the cameras; or zero.

  Eigen::Vector3d Direction() const { return -motion.R.transpose() * motion.t; }  ///< Of B's position in A.
};

void SortByScore(std::vector<ScoredMotion>& motions) {
  std::stable_sort(motions.begin(), motions.end(),
                   [](const ScoredMotion& a, const ScoredMotion& b) { return a.score < b.score; });
}

/// Descends from `start`, then chooses again among the four decompositions.
ScoredMotion Descend(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, RelativeMotion start,
                     double threshold) {
  constexpr int kSteps = 8;
  for (int step = 0; step < kSteps; ++step) Refine(pairs, inliers, start);
  const RelativeMotion best = ChooseByDepth(start.E(), pairs, inliers);
  return {best, Score(pairs, best, threshold)};
}

/// The motions that the homography of a plane in front of camera A allows; the lowest score first. A homography has
/// three numbers more than a motion, but of a plane it leaves no worse: the plane's normal. "In front" is what most of
/// the pairs say: some far ones are of other things, and lie beyond the plane's horizon.
std::vector<ScoredMotion> PlaneCandidates(const std::vector<PointPair>& pairs, const std::vector<int>& use,
                                          const Eigen::Matrix3d& H, double threshold) {
  std::vector<ScoredMotion> candidates;
  for (const PlaneMotion& plane : DecomposeHomography(H)) {
    if (!(plane.t.norm() > 0)) continue;
    const auto in_front = std::count_if(use.begin(), use.end(),
                                        [&](int i) { return plane.normal.dot(pairs[size_t(i)].a.homogeneous()) > 0; });
    if (2 * in_front < std::ptrdiff_t(use.size())) continue;
    const RelativeMotion motion{plane.R, plane.t.normalized()};
    candidates.push_back({motion, Score(pairs, motion, threshold), -plane.normal});
  }
  SortByScore(candidates);
  return candidates;
}

/// Small motions leave the two-view error with several minima, of which some trade a sideways motion for a turn
/// (Chiuso, Brockett and Soatto, IJCV 2000), and views of a plane have two. So descends from the robust answer, from
/// its rotation with each axis as direction, and from what the inliers' homography allows (`planes`). Lowest score
/// first.
std::vector<ScoredMotion> RefineFromSeveral(const std::vector<PointPair>& pairs, const std::vector<int>& inliers,
                                            const RelativeMotion& found, const std::vector<ScoredMotion>& planes,
                                            const Eigen::Matrix3d& R_alone, double threshold) {
  std::vector<RelativeMotion> starts = {found};
  for (const Eigen::Matrix3d& R : {found.R, R_alone}) {
    for (int axis = 0; axis < 3; ++axis) starts.push_back({R, Eigen::Vector3d::Unit(axis)});
  }
  for (const ScoredMotion& candidate : planes) starts.push_back(candidate.motion);
  std::vector<ScoredMotion> refined;
  for (const RelativeMotion& start : starts) refined.push_back(Descend(pairs, inliers, start, threshold));
  SortByScore(refined);
  constexpr int kRounds = 3;  // the inliers were those of a model from five pairs: now they are the best motion's
  for (int round = 0; round < kRounds; ++round) {
    const RelativeMotion& best = refined.front().motion;
    const ScoredMotion again = Descend(pairs, InliersInFront(pairs, best, threshold), best, threshold);
    if (!(again.score < refined.front().score)) break;
    refined.front() = again;
  }
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

enum class Verdict { kGeneral, kPlane, kTurn };

/// Model selection among general motion, plane and rotation by GRIC over the pairs `use`. Errors are weighed with the
/// noise that the general model leaves.
Verdict Judge(const std::vector<PointPair>& pairs, const std::vector<int>& use, const RelativeMotion& motion,
              const std::optional<Eigen::Matrix3d>& H, const Eigen::Matrix3d& R_alone, double threshold) {
  const Eigen::Matrix3d E = motion.E();
  double sigma2 = 0;
  int count = 0;
  for (const int i : use) {
    const double error2 = SampsonError2(E, pairs[size_t(i)]);
    if (!(error2 < threshold * threshold)) continue;
    sigma2 += error2;
    ++count;
  }
  sigma2 = std::max(sigma2 / std::max(count - 5, 1), 1e-16);
  // A transfer error lives in one image: half of its square is what both images' errors would have to be.
  const double general = Gric(use, sigma2, 3, 5, [&](int i) { return SampsonError2(E, pairs[size_t(i)]); });
  const double turn = Gric(use, sigma2, 2, 3, [&](int i) { return TransferError2(R_alone, pairs[size_t(i)]) / 2; });
  const auto flat = [&](int i) { return TransferError2(*H, pairs[size_t(i)]) / 2; };
  const double plane = H ? Gric(use, sigma2, 2, 8, flat) : general;
  if (turn < general && turn <= plane) return Verdict::kTurn;
  return plane < general ? Verdict::kPlane : Verdict::kGeneral;
}

/// Of the motions that a plane allows: where one of them has a level plane below, the others take the direction of
/// travel for the plane's normal. They go, unless that one explains the pairs much worse: then no motion is certain.
void PreferFloor(const std::optional<Eigen::Vector3d>& up_A, std::vector<ScoredMotion>& planes) {
  constexpr double kLevel_rad = 30 * kRadPerDeg, kMuchWorse = 2;
  if (!up_A) return;
  const auto floor = std::find_if(planes.begin(), planes.end(), [&](const ScoredMotion& plane) {
    return plane.normal.dot(*up_A) > std::cos(kLevel_rad);
  });
  if (floor == planes.end()) return;
  const ScoredMotion of_floor = *floor, best = planes.front();
  planes = {of_floor};
  if (of_floor.score <= kMuchWorse * best.score) return;
  planes = {best, of_floor};
  planes.back().score = best.score;  // on a par, so that Alternative() reports it
}

/// A motion in another direction that explains the pairs about as well as the first and best of `sorted`.
std::optional<Pose> Alternative(const std::vector<ScoredMotion>& sorted) {
  constexpr double kAboutAsGood = 1.2;  // scores are sums of squares: 1.1 times the residual
  constexpr double kSame_rad = 15 * kRadPerDeg;
  for (const ScoredMotion& other : sorted) {
    if (!(other.score < kAboutAsGood * sorted.front().score)) break;
    if (other.Direction().dot(sorted.front().Direction()) > std::cos(kSame_rad)) continue;
    return Pose(other.motion.R, other.motion.t).Inverse();
  }
  return {};
}

std::vector<int> InliersOfTurn(const std::vector<PointPair>& pairs, const Eigen::Matrix3d& R, double threshold) {
  std::vector<int> inliers;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (TransferError2(R, pairs[i]) < threshold * threshold) inliers.push_back(int(i));
  }
  return inliers;
}

double MedianParallax(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const Eigen::Matrix3d& R) {
  std::vector<double> angles;
  for (const int i : inliers) {
    const Eigen::Vector3d a = R * pairs[size_t(i)].a.homogeneous(), b = pairs[size_t(i)].b.homogeneous();
    angles.push_back(std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return UpperMedian(std::move(angles));
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

TwoView DescribeTwoView(const std::vector<PointPair>& pairs, const RelativeMotion& motion, double threshold) {
  TwoView result;
  result.X_AB = Pose(motion.R, motion.t).Inverse();
  result.inliers = InliersInFront(pairs, motion, threshold);
  if (result.inliers.size() < kMinPairs) result.inliers.clear();
  if (result.inliers.empty()) return result;
  result.direction_sigma = DirectionSigma(pairs, result.inliers, motion);
  result.parallax = MedianParallax(pairs, result.inliers, motion.R);
  return result;
}

TwoView RefineTwoView(const std::vector<PointPair>& pairs, const Eigen::Matrix3d& E, const std::vector<int>& found,
                      double threshold, const std::optional<Eigen::Vector3d>& up_A) {
  TwoView result;
  result.X_AB.translation = Eigen::Vector3d::UnitX();
  if (found.size() < kMinPairs) return result;
  const std::optional<Eigen::Matrix3d> H = EstimateHomographyRobustly(pairs, found, threshold / 2);
  const Eigen::Matrix3d R_alone = RotationAlone(pairs, found, threshold / 2);
  std::vector<ScoredMotion> planes;
  if (H) planes = PlaneCandidates(pairs, found, *H, threshold);
  std::vector<ScoredMotion> candidates =
      RefineFromSeveral(pairs, found, ChooseByDepth(E, pairs, found), planes, R_alone, threshold);
  const Verdict verdict = Judge(pairs, found, candidates.front().motion, H, R_alone, threshold);
  result.rotation_only = verdict == Verdict::kTurn;
  result.planar = verdict == Verdict::kPlane;
  if (result.rotation_only) candidates = {{{R_alone, candidates.front().motion.t}}};
  if (result.planar) candidates = planes;
  if (candidates.empty()) return result;
  if (result.planar) PreferFloor(up_A, candidates);
  const RelativeMotion& motion = candidates.front().motion;
  result.X_AB = Pose(motion.R, motion.t).Inverse();
  result.inliers =
      result.rotation_only ? InliersOfTurn(pairs, motion.R, threshold) : InliersInFront(pairs, motion, threshold);
  if (result.inliers.size() < kMinPairs) result.inliers.clear();
  if (result.inliers.empty()) return result;
  result.direction_sigma = DirectionSigma(pairs, result.inliers, motion);
  result.parallax = MedianParallax(pairs, result.inliers, motion.R);
  result.alternative = Alternative(candidates);
  return result;
}

TwoView EstimateTwoView(const std::vector<PointPair>& pairs, const RansacOptions& options, RandomStream& random) {
  if (pairs.size() < kMinPairs) return RefineTwoView(pairs, Eigen::Matrix3d::Identity(), {}, options.threshold);
  const auto found = EstimateEssential(pairs, options, random, SampsonError2);
  return RefineTwoView(pairs, found.model, found.inliers, options.threshold);
}

}  // namespace gaitcam
