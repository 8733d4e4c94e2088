#include "algorithms/geometry/homography.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/eight_point.h"

namespace gaitcam {

namespace {

/// Normalised direct linear transform; the equations of pair use[k] weigh weights[k].
std::optional<Eigen::Matrix3d> WeightedHomography(const std::vector<PointPair>& pairs, const std::vector<int>& use,
                                                  const std::vector<double>& weights) {
  if (use.size() < 4) return std::nullopt;
  std::vector<Eigen::Vector2d> as, bs;
  for (const int i : use) {
    as.push_back(pairs[size_t(i)].a);
    bs.push_back(pairs[size_t(i)].b);
  }
  const Eigen::Matrix3d Ta = NormalisingTransform(as), Tb = NormalisingTransform(bs);
  Eigen::Matrix<double, 9, 9> N = Eigen::Matrix<double, 9, 9>::Zero();
  for (size_t k = 0; k < as.size(); ++k) {
    const Eigen::Vector3d a = Ta * as[k].homogeneous(), b = Tb * bs[k].homogeneous();
    Eigen::Matrix<double, 2, 9> rows;
    rows << a.transpose(), 0, 0, 0, -b.x() * a.transpose(), 0, 0, 0, a.transpose(), -b.y() * a.transpose();
    N.noalias() += weights[k] * rows.transpose() * rows;
  }
  const Eigen::Matrix<double, 9, 1> h = SmallestEigenvector(N);
  Eigen::Matrix3d H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  H = Tb.inverse() * H * Ta;
  const double middle = SvdOf(H).values[1];
  if (!H.allFinite() || !(middle > 0)) return std::nullopt;
  H /= middle;
  int positive = 0;
  for (const int i : use) {
    positive += pairs[size_t(i)].b.homogeneous().dot(H * pairs[size_t(i)].a.homogeneous()) > 0 ? 1 : -1;
  }
  return positive >= 0 ? H : Eigen::Matrix3d(-H);
}

}  // namespace

std::optional<Eigen::Matrix3d> EstimateHomography(const std::vector<PointPair>& pairs, const std::vector<int>& use) {
  return WeightedHomography(pairs, use, std::vector<double>(use.size(), 1.0));
}

std::optional<Eigen::Matrix3d> EstimateHomographyRobustly(const std::vector<PointPair>& pairs,
                                                          const std::vector<int>& use, double threshold) {
  std::vector<double> weights(use.size(), 1.0);
  std::optional<Eigen::Matrix3d> H = WeightedHomography(pairs, use, weights);
  constexpr int kRounds = 8;
  for (int round = 0; H && round < kRounds; ++round) {
    for (size_t k = 0; k < use.size(); ++k) {
      const double error2 = TransferError2(*H, pairs[size_t(use[k])]) / (threshold * threshold);
      weights[k] = 1 / std::pow(1 + error2, 2);  // Geman and McClure's; zero behind
    }
    H = WeightedHomography(pairs, use, weights);
  }
  return H;
}

double TransferError2(const Eigen::Matrix3d& H, const PointPair& pair) {
  const Eigen::Vector3d b = H * pair.a.homogeneous();
  return b.z() > 0 ? (b.hnormalized() - pair.b).squaredNorm() : std::numeric_limits<double>::infinity();
}

std::vector<PlaneMotion> DecomposeHomography(const Eigen::Matrix3d& H) {
  const SymmetricEigen3 eigen = EigenOfSymmetric(H.transpose() * H);
  const double middle = eigen.values[1];
  const double s1 = eigen.values[2] / middle, s3 = eigen.values[0] / middle;  // squared, >= 1 and <= 1
  const Eigen::Matrix3d G = H / std::sqrt(middle);
  constexpr double kRotation = 1e-12;
  if (!(s1 - s3 > kRotation)) {
    const Svd3 svd = SvdOf(G);
    return {{svd.U * svd.V.transpose(), Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}};
  }
  Eigen::Vector3d v1 = eigen.vectors.col(2);
  const Eigen::Vector3d v2 = eigen.vectors.col(1), v3 = eigen.vectors.col(0);
  if (v1.cross(v2).dot(v3) < 0) v1 = -v1;
  std::vector<PlaneMotion> motions;
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d u =
        (std::sqrt(std::max(0.0, 1 - s3)) * v1 + sign * std::sqrt(std::max(0.0, s1 - 1)) * v3) / std::sqrt(s1 - s3);
    Eigen::Matrix3d U, W;
    U << v2, u, v2.cross(u);
    W << G * v2, G * u, (G * v2).cross(G * u);
    const Eigen::Matrix3d R = W * U.transpose();
    const Eigen::Vector3d n = v2.cross(u), t = (G - R) * n;
    motions.push_back({R, t, n});
    motions.push_back({R, -t, -n});
  }
  return motions;
}

}  // namespace gaitcam
