#include "algorithms/geometry/eight_point.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/householder.h"

namespace gaitcam {

Eigen::Matrix3d NormalisingTransform(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) centroid += p / double(points.size());
  double distance = 0;
  for (const Eigen::Vector2d& p : points) distance += (p - centroid).norm() / double(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Eigen::Matrix3d T;
  T << scale, 0, -scale * centroid.x(), 0, scale, -scale * centroid.y(), 0, 0, 1;
  return T;
}

std::optional<Eigen::Matrix3d> SolveEightPoint(const std::vector<PointPair>& pairs) {
  if (pairs.size() < 8) return std::nullopt;
  std::vector<Eigen::Vector2d> as, bs;
  for (const PointPair& pair : pairs) {
    as.push_back(pair.a);
    bs.push_back(pair.b);
  }
  const Eigen::Matrix3d Ta = NormalisingTransform(as), Tb = NormalisingTransform(bs);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(std::max<long>(9, long(pairs.size())), 9);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const Eigen::Vector3d a = Ta * pairs[k].a.homogeneous(), b = Tb * pairs[k].b.homogeneous();
    for (int i = 0; i < 3; ++i) A.row(long(k)).segment<3>(3 * i) = b[i] * a.transpose();
  }
  // The right singular vectors of A are those of its triangular factor.
  Eigen::VectorXd tau(9);
  FactorQr(A, tau);
  const Eigen::Matrix<double, 9, 9> R = A.topRows<9>().triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(R, Eigen::ComputeFullV);
  const Eigen::Matrix<double, 9, 1> e = svd.matrixV().col(8);
  Eigen::Matrix3d F;
  F << e[0], e[1], e[2], e[3], e[4], e[5], e[6], e[7], e[8];
  const Svd3 parts = SvdOf(Tb.transpose() * F * Ta);
  const Eigen::Matrix3d E = parts.U * Eigen::Vector3d(1, 1, 0).asDiagonal() * parts.V.transpose();
  if (!E.allFinite() || !(parts.values[1] > 0)) return std::nullopt;
  return E;
}

}  // namespace gaitcam
