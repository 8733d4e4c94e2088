#include "algorithms/geometry/two_view.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace gaitcam {
namespace {

constexpr size_t kFewestPairs = 8;  // five determine the pose; three more to tell a pose from chance

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

/// E = [t]x R of the motion p_B = R p_A + t.
struct Motion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d E() const { return Skew(t) * R; }
};

/// Depths (z_A, z_B) of the point nearest to both rays: z_B b = z_A R a + t in least squares.
Eigen::Vector2d Depths(const Motion& motion, const PointPair& pair) {
  Eigen::Matrix<double, 3, 2> A;
  A.col(0) = -(motion.R * pair.a.homogeneous());
  A.col(1) = pair.b.homogeneous();
  const Eigen::Matrix2d N = A.transpose() * A;
  const double determinant = N.determinant();
  if (!(std::abs(determinant) > 1e-14)) return {-1, -1};  // parallel rays have no depth
  return N.inverse() * (A.transpose() * motion.t);
}

bool InFront(const Motion& motion, const PointPair& pair) { return (Depths(motion, pair).array() > 0).all(); }

/// The four motions of an essential matrix (Hartley and Zisserman 2003, result 9.19).
std::vector<Motion> Decompose(const Eigen::Matrix3d& E) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV(), W;
  if (U.determinant() < 0) U = -U;
  if (V.determinant() < 0) V = -V;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d t = U.col(2);
  const Eigen::Matrix3d R1 = U * W * V.transpose(), R2 = U * W.transpose() * V.transpose();
  return {{R1, t}, {R1, -t}, {R2, t}, {R2, -t}};
}

/// The decomposition that puts most points before both cameras.
Motion ChooseByDepth(const Eigen::Matrix3d& E, const std::vector<PointPair>& pairs, const std::vector<int>& inliers) {
  Motion best;
  int most = -1;
  for (const Motion& motion : Decompose(E)) {
    int count = 0;
    for (const int i : inliers) count += InFront(motion, pairs[size_t(i)]);
    if (count > most) {
      most = count;
      best = motion;
    }
  }
  return best;
}

/// Normal equations of the inliers' Sampson errors in (turn w of R exp(w), t along its two tangents); the errors'
/// denominators are held fixed.
struct NormalEquations {
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
  double error2 = 0;
  Eigen::Vector3d u, v;  ///< Tangents of the sphere of directions at t.

  NormalEquations(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const Motion& motion)
      : u(motion.t.unitOrthogonal()), v(motion.t.cross(u)) {
    const Eigen::Matrix3d E = motion.E();
    std::vector<Eigen::Matrix3d> derivative;
    for (int k = 0; k < 3; ++k) derivative.push_back(E * Skew(Eigen::Vector3d::Unit(k)));
    derivative.push_back(Skew(u) * motion.R);
    derivative.push_back(Skew(v) * motion.R);
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
void Refine(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, Motion& motion) {
  const NormalEquations equations(pairs, inliers, motion);
  const Eigen::Matrix<double, 5, 1> step = -equations.H.ldlt().solve(equations.g);
  constexpr double kLargestStep = 0.2;  // beyond it (rad) the linearisation is worthless
  if (!step.allFinite() || step.norm() > kLargestStep) return;
  const Eigen::Vector3d w = step.head<3>();
  if (w.norm() > 0) motion.R = motion.R * Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  motion.t = (motion.t + step[3] * equations.u + step[4] * equations.v).normalized();
}

/// Of the direction of X_AB's translation, d = -R^T t: the covariance sigma^2 H^-1 of turn and t, propagated to d.
double DirectionSigma(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const Motion& motion) {
  const NormalEquations equations(pairs, inliers, motion);
  const double sigma2 = equations.error2 / double(inliers.size() - 5);
  const Eigen::Matrix<double, 5, 5> covariance = sigma2 * equations.H.inverse();
  if (!covariance.allFinite()) return M_PI;
  Eigen::Matrix<double, 3, 5> J;  // (R exp(w))^T t = R^T t - w x R^T t to first order
  J << Skew(motion.R.transpose() * motion.t), motion.R.transpose() * equations.u, motion.R.transpose() * equations.v;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(J * covariance * J.transpose());
  const double largest = eigen.eigenvalues()[2];
  return largest >= 0 ? std::min(M_PI, std::sqrt(largest)) : M_PI;
}

std::vector<int> InliersInFront(const std::vector<PointPair>& pairs, const Motion& motion, double threshold) {
  std::vector<int> inliers;
  const Eigen::Matrix3d E = motion.E();
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (SampsonError2(E, pairs[i]) < threshold * threshold && InFront(motion, pairs[i])) inliers.push_back(int(i));
  }
  return inliers;
}

/// The rotation that alone brings the rays a nearest to the rays b (Arun, Huang and Blostein, PAMI 1987).
Eigen::Matrix3d RotationAlone(const std::vector<PointPair>& pairs, const std::vector<int>& inliers) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const int i : inliers) {
    sum += pairs[size_t(i)].b.homogeneous().normalized() * pairs[size_t(i)].a.homogeneous().normalized().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// Small motions leave the two-view error with several minima, of which some trade a sideways motion for a turn
/// (Chiuso, Brockett and Soatto, IJCV 2000). So descends from RANSAC's answer and from its rotation with each axis as
/// direction, and keeps the lowest.
Motion RefineFromSeveral(const std::vector<PointPair>& pairs, const std::vector<int>& inliers, const Motion& found,
                         const RansacOptions& options) {
  std::vector<Motion> starts = {found};
  for (const Eigen::Matrix3d& R : {found.R, RotationAlone(pairs, inliers)}) {
    for (int axis = 0; axis < 3; ++axis) starts.push_back({R, Eigen::Vector3d::Unit(axis)});
  }
  Motion best = found;
  double lowest = std::numeric_limits<double>::infinity();
  constexpr int kSteps = 8;
  for (Motion& motion : starts) {
    for (int step = 0; step < kSteps; ++step) Refine(pairs, inliers, motion);
    motion = ChooseByDepth(motion.E(), pairs, inliers);
    const Eigen::Matrix3d E = motion.E();
    double score = 0;
    for (const PointPair& pair : pairs) {
      score += InFront(motion, pair) ? std::min(SampsonError2(E, pair), options.threshold * options.threshold)
                                     : options.threshold * options.threshold;
    }
    if (score < lowest) {
      lowest = score;
      best = motion;
    }
  }
  return best;
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

std::vector<Eigen::Matrix3d> SolveFivePoint(const std::vector<PointPair>& five) {
  std::vector<cv::Point2d> a, b;
  for (const PointPair& pair : five) {
    a.emplace_back(pair.a.x(), pair.a.y());
    b.emplace_back(pair.b.x(), pair.b.y());
  }
  // With exactly five pairs OpenCV's estimator draws no sample: it returns all solutions, stacked.
  const cv::Mat stacked = cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.99, 1.0);
  std::vector<Eigen::Matrix3d> solutions;
  for (int row = 0; row + 3 <= stacked.rows; row += 3) {
    Eigen::Matrix3d E;
    for (int i = 0; i < 9; ++i) E(i / 3, i % 3) = stacked.at<double>(row + i / 3, i % 3);
    if (E.allFinite() && E.norm() > 0) solutions.push_back(E);
  }
  return solutions;
}

double SampsonError2(const Eigen::Matrix3d& E, const PointPair& pair) {
  const Eigen::Vector3d Ea = E * pair.a.homogeneous(), Etb = E.transpose() * pair.b.homogeneous();
  const double algebraic = pair.b.homogeneous().dot(Ea);
  const double gradient2 = Ea.head<2>().squaredNorm() + Etb.head<2>().squaredNorm();
  return gradient2 > 0 ? algebraic * algebraic / gradient2 : std::numeric_limits<double>::infinity();
}

TwoView EstimateTwoView(const std::vector<PointPair>& pairs, const RansacOptions& options, RandomStream& random) {
  TwoView result;
  result.X_AB.translation = Eigen::Vector3d::UnitX();
  if (pairs.size() < kFewestPairs) return result;
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<PointPair> five;
    for (const int i : sample) five.push_back(pairs[size_t(i)]);
    return SolveFivePoint(five);
  };
  const auto residual2 = [&](const Eigen::Matrix3d& E, int i) { return SampsonError2(E, pairs[size_t(i)]); };
  const auto found = Ransac<Eigen::Matrix3d>(int(pairs.size()), 5, options, random, solve, residual2);
  if (found.inliers.size() < kFewestPairs) return result;
  Motion motion = RefineFromSeveral(pairs, found.inliers, ChooseByDepth(found.model, pairs, found.inliers), options);
  std::vector<int> inliers = InliersInFront(pairs, motion, options.threshold);
  if (inliers.size() < kFewestPairs) return result;
  result.X_AB = Pose(motion.R, motion.t).Inverse();
  result.direction_sigma = DirectionSigma(pairs, inliers, motion);
  result.parallax = MedianParallax(pairs, inliers, motion.R);
  result.inliers = std::move(inliers);
  return result;
}

}  // namespace gaitcam
