#include "algorithms/geometry/relative_motion.h"

#include <Eigen/LU>
#include <cmath>

#include "algorithms/core/small_solvers.h"

namespace gaitcam {

Eigen::Vector2d Depths(const RelativeMotion& motion, const PointPair& pair) {
  const Eigen::Vector3d a = motion.R * pair.a.homogeneous(), b = pair.b.homogeneous();
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double at = a.dot(motion.t), bt = b.dot(motion.t), determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-14)) return {-1, -1};
  return Eigen::Vector2d(ab * bt - bb * at, aa * bt - ab * at) / determinant;
}

bool InFront(const RelativeMotion& motion, const PointPair& pair) {
  const Eigen::Vector2d depths = Depths(motion, pair);
  return depths.x() > 0 && depths.y() > 0;
}

std::vector<RelativeMotion> DecomposeEssential(const Eigen::Matrix3d& E) {
  const Svd3 svd = SvdOf(E);
  Eigen::Matrix3d U = svd.U, V = svd.V, W;
  if (U.determinant() < 0) U = -U;
  if (V.determinant() < 0) V = -V;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d t = U.col(2);
  const Eigen::Matrix3d R1 = U * W * V.transpose(), R2 = U * W.transpose() * V.transpose();
  return {{R1, t}, {R1, -t}, {R2, t}, {R2, -t}};
}

RelativeMotion ChooseByDepth(const Eigen::Matrix3d& E, const std::vector<PointPair>& pairs,
                             const std::vector<int>& use) {
  RelativeMotion best;
  int max_count = -1;
  for (const RelativeMotion& motion : DecomposeEssential(E)) {
    int count = 0;
    for (const int i : use) count += InFront(motion, pairs[size_t(i)]);
    if (count > max_count) {
      max_count = count;
      best = motion;
    }
  }
  return best;
}

Eigen::Matrix3d RotationAlone(const std::vector<PointPair>& pairs, const std::vector<int>& use, double threshold) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  constexpr int kRounds = 8;  // the first without weights
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const int i : use) {
      const Eigen::Vector3d a = pairs[size_t(i)].a.homogeneous().normalized();
      const Eigen::Vector3d b = pairs[size_t(i)].b.homogeneous().normalized();
      const double error2 = (b - R * a).squaredNorm() / (threshold * threshold);
      sum += (round == 0 ? 1 : 1 / std::pow(1 + error2, 2)) * b * a.transpose();  // Geman and McClure's weights
    }
    R = SvdOf(sum).NearestRotation();
  }
  return R;
}

}  // namespace gaitcam
