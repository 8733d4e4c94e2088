#include "algorithms/geometry/stereo_motion.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/stereo_projection.h"

namespace gaitcam {
namespace {

using Matrix86 = Eigen::Matrix<double, 8, 6>;
using Matrix83 = Eigen::Matrix<double, 8, 3>;

/// A point as it is sought: q = (x/z, y/z, 1/z) in frame B, and what both pairs show of it.
struct SoughtPoint {
  Eigen::Vector3d q;
  IdealSighting A, B;
};

/// Residuals of one point, whitened, with their derivatives by the motion and by the point.
struct PointEquations {
  Eigen::Matrix<double, 8, 1> r;
  Matrix86 by_motion;
  Matrix83 by_point;

  PointEquations(const StereoRig& rig, const SoughtPoint& point, const Pose& X_AB) {
    const Eigen::Matrix3d R = X_AB.R();
    const Eigen::Vector3d ray(point.q.x(), point.q.y(), 1);
    const double w = point.q.z();
    // The point in A times w: h = R ray + t w, and A's own q = (h_x, h_y, w) / h_z.
    const Eigen::Vector3d h = R * ray + X_AB.translation * w;
    const Eigen::Vector3d q_A(h.x() / h.z(), h.y() / h.z(), w / h.z());
    Eigen::Matrix3d by_h, h_by_q;
    by_h << 1, 0, -q_A.x(), 0, 1, -q_A.y(), 0, 0, -q_A.z();
    by_h /= h.z();
    h_by_q << R.col(0), R.col(1), X_AB.translation;
    Eigen::Matrix3d q_A_by_q = by_h * h_by_q;
    q_A_by_q(2, 2) += 1 / h.z();
    Eigen::Matrix<double, 3, 6> q_A_by_motion;
    q_A_by_motion << by_h * R * w, -by_h * R * Hat(ray);

    const StereoProjection in_A(rig, q_A), in_B(rig, point.q);
    r << point.A.whiten * (in_A.u - point.A.u), point.B.whiten * (in_B.u - point.B.u);
    by_motion << point.A.whiten * in_A.J * q_A_by_motion, Eigen::Matrix<double, 4, 6>::Zero();
    by_point << point.A.whiten * in_A.J * q_A_by_q, point.B.whiten * in_B.J;
  }
};

/// What a step of all unknowns solves: the motion's normal equations with the points eliminated.
struct ReducedSystem {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;

  void Add(const PointEquations& e, const Eigen::Matrix3d& inverse_of_point) {
    const Eigen::Matrix<double, 6, 3> mixed = e.by_motion.transpose() * e.by_point;
    const Eigen::Vector3d by_point = e.by_point.transpose() * e.r;
    information += e.by_motion.transpose() * e.by_motion - mixed * inverse_of_point * mixed.transpose();
    gradient += e.by_motion.transpose() * e.r - mixed * inverse_of_point * by_point;
    cost += e.r.squaredNorm();
  }
};

std::vector<SoughtPoint> StartingPoints(const StereoRig& rig, const std::vector<StereoSighting>& A,
                                        const std::vector<StereoSighting>& B) {
  std::vector<SoughtPoint> points;
  for (size_t k = 0; k < A.size(); ++k) {
    const std::optional<IdealSighting> a = IdealSighting::Of(rig, A[k]), b = IdealSighting::Of(rig, B[k]);
    if (!a || !b) continue;
    const StereoPoint point = ReconstructPoint(rig, B[k], {StereoCost::kMaximumLikelihood, 0});
    // Rays that diverge by noise are of a point that is far; to leave it out would favour those that look near.
    const Eigen::Vector3d p = point.ok() ? point.p_L : b->ray_left;
    points.push_back({{p.x() / p.z(), p.y() / p.z(), point.ok() ? 1 / p.z() : 0}, *a, *b});
  }
  return points;
}

}  // namespace

LikelyMotion RefineStereoMotion(const StereoRig& rig, const std::vector<StereoSighting>& A,
                                const std::vector<StereoSighting>& B, const Pose& X_AB) {
  GAITCAM_ASSERT(A.size() == B.size());
  LikelyMotion result{X_AB, Matrix6d::Constant(std::numeric_limits<double>::quiet_NaN()), 0};
  std::vector<SoughtPoint> points = StartingPoints(rig, A, B);
  constexpr size_t kMinPoints = 3;
  if (points.size() < kMinPoints) return result;
  constexpr int kSteps = 20;
  constexpr double kArrived = 1e-10;  // m and rad
  Matrix6d information;
  for (int step = 0; step < kSteps; ++step) {
    ReducedSystem system;
    std::vector<PointEquations> equations;
    std::vector<Eigen::Matrix3d> inverses;
    for (const SoughtPoint& point : points) {
      equations.emplace_back(rig, point, result.X_AB);
      inverses.push_back(InverseOfSymmetric<3>(equations.back().by_point.transpose() * equations.back().by_point));
      system.Add(equations.back(), inverses.back());
    }
    const Vector6d change = -SolveSymmetric<6>(system.information, system.gradient);
    if (!change.allFinite()) return result;
    for (size_t k = 0; k < points.size(); ++k) {
      const PointEquations& e = equations[k];
      points[k].q -= inverses[k] * e.by_point.transpose() * (e.r + e.by_motion * change);
    }
    result.X_AB = Plus(result.X_AB, change);
    result.cost = system.cost;
    information = system.information;
    if (change.norm() < kArrived) break;
  }
  result.covariance = InverseOfSymmetric<6>(information);
  return result;
}

}  // namespace gaitcam
