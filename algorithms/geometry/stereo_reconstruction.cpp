#include "algorithms/geometry/stereo_reconstruction.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/stereo_projection.h"

namespace gaitcam {
namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;
using Matrix43 = Eigen::Matrix<double, 4, 3>;

/// What a cost function makes of four ideal pixels: the point and its derivatives by them.
struct Reconstruction {
  Eigen::Vector3d p;
  Matrix34 J;
  std::array<Eigen::Matrix4d, 3> hessians;  ///< Of each coordinate.
};

/// Eq. 2.3, its rows in the order u, v, u', v', so that row i depends on ideal pixel coordinate i alone, and linearly:
/// its derivative is (slope.row(i), slope_b(i)).
struct LinearSystem {
  Matrix43 A, slope;
  Eigen::Vector4d b, slope_b;

  LinearSystem(const StereoRig& rig, const Eigen::Vector4d& u) {
    const Pose X_RL = rig.X_LR.Inverse();
    const Eigen::Matrix3d R = X_RL.R();
    const Eigen::Vector3d t = X_RL.translation;
    slope << 0, 0, 1, 0, 0, 1, R.row(2), R.row(2);
    slope_b << 0, 0, -t.z(), -t.z();
    A << -rig.left.fx, 0, u[0] - rig.left.cx,                        //
        0, -rig.left.fy, u[1] - rig.left.cy,                         //
        (u[2] - rig.right.cx) * R.row(2) - rig.right.fx * R.row(0),  //
        (u[3] - rig.right.cy) * R.row(2) - rig.right.fy * R.row(1);
    b << 0, 0, (rig.right.cx - u[2]) * t.z() + rig.right.fx * t.x(),
        (rig.right.cy - u[3]) * t.z() + rig.right.fy * t.y();
  }
};

/// Eq. 2.26, and the derivatives of p by the implicit function theorem (Eq. 2.27): at the minimum of Eq. 2.25
///   Phi = A^T (A p - b) = sum_k a_k e_k = 0,   e_i = a_i p - b_i,   d_i = d e_i / d u_i,
/// so that with N = A^T A and s_i = d a_i / d u_i
///   N p_i = -(s_i e_i + a_i d_i),
///   N p_ij = -(s_j (a_j p_i) + a_j (s_j p_i) + s_i (a_i p_j) + a_i (s_i p_j) + 2 [i = j] s_i d_i).
Reconstruction ReconstructLinearly(const StereoRig& rig, const Eigen::Vector4d& u) {
  const LinearSystem system(rig, u);
  const Matrix43 &A = system.A, &S = system.slope;
  const Eigen::Matrix3d inverse = InverseOfSymmetric<3>(A.transpose() * A);
  Reconstruction result;
  result.p = inverse * (A.transpose() * system.b);
  // One step of refinement: what the normal equations lose is twice the digits that A does.
  result.p -= inverse * (A.transpose() * (A * result.p - system.b));
  const Eigen::Vector4d e = A * result.p - system.b, d = S * result.p - system.slope_b;
  for (int i = 0; i < 4; ++i) result.J.col(i) = -inverse * (S.row(i) * e[i] + A.row(i) * d[i]).transpose();
  const Eigen::Matrix4d a_p = A * result.J, s_p = S * result.J;  // (i, j): a_i p_j, s_i p_j
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      Eigen::RowVector3d sum =
          S.row(j) * a_p(j, i) + A.row(j) * s_p(j, i) + S.row(i) * a_p(i, j) + A.row(i) * s_p(i, j);
      if (i == j) sum += 2 * S.row(i) * d[i];
      const Eigen::Vector3d p_ij = -inverse * sum.transpose();
      for (int k = 0; k < 3; ++k) result.hessians[size_t(k)](i, j) = result.hessians[size_t(k)](j, i) = p_ij[k];
    }
  }
  return result;
}

/// The q that minimises r^T W r, r = projection - u, by Gauss-Newton; nothing if the point gets behind a camera.
std::optional<Eigen::Vector3d> MostLikely(const StereoRig& rig, const Eigen::Vector4d& u, const Eigen::Matrix4d& W,
                                          Eigen::Vector3d q) {
  constexpr int kSteps = 20;
  constexpr double kArrived = 1e-13;  // of coordinates of order one
  for (int step = 0; step < kSteps; ++step) {
    const StereoProjection projection(rig, q);
    const Eigen::Matrix<double, 3, 4> JW = projection.J.transpose() * W;
    const Eigen::Vector3d change = SolveSymmetric<3>(JW * projection.J, JW * (projection.u - u));
    q -= change;
    if (!q.allFinite()) return std::nullopt;
    if (change.norm() < kArrived * (1 + q.norm())) break;
  }
  return q;
}

/// The most likely point and its derivatives by the implicit function theorem (Eq. 2.23): at the minimum
///   Phi = J^T W r = sum_k g_k (W r)_k = 0,   F = d Phi / d q = J^T W J + sum_k H_k (W r)_k,
///   F q_i = (J^T W)_i,
///   F q_ij = -sum_k (H_k q_i (W r_j)_k + H_k q_j (W r_i)_k) - J^T W [q_i^T H_k q_j]_k,   r_i = J q_i - e_i,
/// where third derivatives times residuals are left out; then those of p = (q_x, q_y, 1) / q_z.
std::optional<Reconstruction> ReconstructMostLikely(const StereoRig& rig, const Eigen::Vector4d& u,
                                                    const Eigen::Matrix4d& W, const Eigen::Vector3d& near) {
  const std::optional<Eigen::Vector3d> q =
      MostLikely(rig, u, W, {near.x() / near.z(), near.y() / near.z(), 1 / near.z()});
  if (!q) return std::nullopt;
  const StereoProjection at(rig, *q);
  const Eigen::Vector4d weighted = W * (at.u - u);
  Eigen::Matrix3d F = at.J.transpose() * W * at.J;
  for (size_t k = 2; k < 4; ++k) F += weighted[int(k)] * at.hessians[k];
  const Eigen::Matrix3d inverse = InverseOfSymmetric<3>(F);
  const Matrix34 JW = at.J.transpose() * W, q_u = inverse * JW;
  const Eigen::Matrix4d W_r = W * (at.J * q_u - Eigen::Matrix4d::Identity());  // column i: W r_i
  const double z = 1 / q->z();
  Reconstruction result;
  result.p = {q->x() * z, q->y() * z, z};
  Eigen::Matrix3d p_q;
  p_q << z, 0, -q->x() * z * z, 0, z, -q->y() * z * z, 0, 0, -z * z;
  result.J = p_q * q_u;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      Eigen::Vector4d curvature = Eigen::Vector4d::Zero();
      for (int k = 2; k < 4; ++k) {
        const Eigen::Matrix3d& H = at.hessians[size_t(k)];
        sum += H * (q_u.col(i) * W_r(k, j) + q_u.col(j) * W_r(k, i));
        curvature[k] = q_u.col(i).dot(H * q_u.col(j));
      }
      const Eigen::Vector3d a = q_u.col(i), b = q_u.col(j);
      Eigen::Vector3d p_ij = p_q * (-inverse * (sum + JW * curvature));
      for (int k = 0; k < 2; ++k)
        p_ij[k] += -z * z * (a[k] * b.z() + b[k] * a.z()) + 2 * (*q)[k] * z * z * z * a.z() * b.z();
      p_ij.z() += 2 * z * z * z * a.z() * b.z();
      for (int k = 0; k < 3; ++k) result.hessians[size_t(k)](i, j) = result.hessians[size_t(k)](j, i) = p_ij[k];
    }
  }
  return result;
}

bool BehindACamera(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  return !(p_L.z() > 0 && (rig.X_LR.Inverse() * p_L).z() > 0);
}

StereoPoint Failed(StereoStatus status) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  StereoPoint point;
  point.status = status;
  point.p_L.setConstant(kNan);
  point.bias.setConstant(kNan);
  point.J.setConstant(kNan);
  point.covariance.setConstant(kNan);
  point.covariance_second.setConstant(kNan);
  point.squared_error = point.nonlinearity = kNan;
  return point;
}

/// First order (Eq. 2.24) and what second order adds for Gaussian errors:
///   E[p] - p = tr(H_k S) / 2,   covariance + tr(H_k S H_l S) / 2.
void Propagate(const Reconstruction& reconstruction, const Eigen::Matrix4d& S, StereoPoint& point) {
  point.covariance = reconstruction.J * S * reconstruction.J.transpose();
  std::array<Eigen::Matrix4d, 3> HS;
  for (size_t k = 0; k < 3; ++k) {
    HS[k] = reconstruction.hessians[k] * S;
    point.bias[int(k)] = HS[k].trace() / 2;
  }
  for (size_t k = 0; k < 3; ++k)
    for (size_t l = 0; l < 3; ++l)
      point.covariance_second(int(k), int(l)) = (HS[k].transpose().cwiseProduct(HS[l])).sum() / 2;
  const Eigen::Matrix3d second = point.covariance_second + point.bias * point.bias.transpose();
  point.nonlinearity = std::sqrt(std::max(0.0, (InverseOfSymmetric<3>(point.covariance) * second).trace()));
  constexpr double kFirstOrder = 0.3;  // by the map of `gaitcam experiment nees`
  point.first_order_holds = point.nonlinearity < kFirstOrder;
}

}  // namespace

StereoPoint ReconstructPoint(const StereoRig& rig, const StereoSighting& sighting,
                             const ReconstructionOptions& options) {
  const std::optional<IdealSighting> ideal = IdealSighting::Of(rig, sighting);
  if (!ideal) return Failed(StereoStatus::kNoRay);
  constexpr double kParallel = 1e-9;  // rounding of pixels, in rad
  if (!(ideal->ray_left.cross(ideal->ray_right).norm() > kParallel)) return Failed(StereoStatus::kParallel);
  const Eigen::Vector4d& u = ideal->u;
  const Eigen::Matrix4d W = ideal->whiten.transpose() * ideal->whiten;

  Reconstruction reconstruction = ReconstructLinearly(rig, u);
  if (BehindACamera(rig, reconstruction.p)) return Failed(StereoStatus::kBehind);
  if (options.cost == StereoCost::kMaximumLikelihood) {
    const auto likely = ReconstructMostLikely(rig, u, W, reconstruction.p);
    if (!likely || BehindACamera(rig, likely->p)) return Failed(StereoStatus::kBehind);
    reconstruction = *likely;
  }
  StereoPoint point;
  point.status = StereoStatus::kOk;
  point.p_L = reconstruction.p;
  point.J = reconstruction.J * ideal->derivative;
  Propagate(reconstruction, ideal->covariance, point);
  if (point.p_L.z() < options.min_depth_sigmas * std::sqrt(point.covariance(2, 2)))
    return Failed(StereoStatus::kTooFar);
  const Eigen::Vector3d& p = point.p_L;
  const Eigen::Vector4d residual = StereoProjection(rig, {p.x() / p.z(), p.y() / p.z(), 1 / p.z()}).u - u;
  point.squared_error = residual.dot(W * residual);
  return point;
}

Eigen::Vector3d SolveLinearly(const StereoRig& rig, const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
  const std::optional<Eigen::Vector4d> u = IdealPixels(rig, left, right);
  if (!u) return Failed(StereoStatus::kNoRay).p_L;
  const LinearSystem system(rig, *u);
  return SolveSymmetric<3>(system.A.transpose() * system.A, system.A.transpose() * system.b);
}

ImageOrder TellImageOrder(const StereoRig& rig, const std::vector<StereoSighting>& matches) {
  // A match speaks for an order in which its rays meet, in front of both cameras and not too far to be sure.
  constexpr double kMeets = 25;  // chi-square of one degree: five standard deviations
  const auto meets = [&](const StereoSighting& sighting) {
    const StereoPoint point = ReconstructPoint(rig, sighting);
    return point.ok() && point.squared_error < kMeets;
  };
  int as_given = 0, swapped = 0;
  for (const StereoSighting& match : matches) {
    as_given += meets(match);
    swapped += meets({match.right, match.left, match.covariance_right, match.covariance_left});
  }
  constexpr int kMinVotes = 10;
  constexpr double kMajority = 0.75;
  const int votes = as_given + swapped;
  if (votes < kMinVotes) return ImageOrder::kUnknown;
  if (as_given >= kMajority * votes) return ImageOrder::kRight;
  return swapped >= kMajority * votes ? ImageOrder::kSwapped : ImageOrder::kUnknown;
}

StereoRig StereoRig::Of(const Calibration& calibration) {
  if (!calibration.right)
    throw BadInput("stereo rig: there is no right camera; expected a calibration with `right` and `X_LR`");
  const StereoRig rig{calibration.camera, *calibration.right, calibration.X_LR};
  rig.Check();
  return rig;
}

double StereoRig::Overlap(double depth_m) const {
  constexpr int kColumns = 24, kRows = 18;
  int seen = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * left.width_px / kColumns - 0.5,
                                  (row + 0.5) * left.height_px / kRows - 0.5);
      const auto there = right.Project(X_LR.Inverse() * (depth_m * left.Unproject(pixel)));
      seen += there && right.Contains(*there);
    }
  }
  return double(seen) / (kColumns * kRows);
}

void StereoRig::Check() const {
  left.Check();
  right.Check();
  constexpr double kUnit = 1e-6, kMinBaseline_m = 1e-6, kMinOverlap = 0.1;
  const double norm = X_LR.rotation.norm(), baseline_m = X_LR.translation.norm();
  if (!(std::abs(norm - 1) < kUnit)) {
    throw BadInput("stereo rig: the rotation of X_LR is none: its quaternion has length " + std::to_string(norm) +
                   "; expected 1");
  }
  if (!(baseline_m > kMinBaseline_m && std::isfinite(baseline_m))) {
    throw BadInput("stereo rig: the two cameras are " + std::to_string(baseline_m) +
                   " m apart (translation of X_LR); expected a baseline above 0");
  }
  double overlap = 0;
  for (double depth_m = baseline_m; depth_m < 1e5 * baseline_m; depth_m *= 2) {
    overlap = std::max(overlap, Overlap(depth_m));
  }
  if (overlap < kMinOverlap) {
    throw BadInput("stereo rig: the two cameras see at most " + std::to_string(int(100 * overlap)) +
                   " % of the left image in common, at whatever depth; expected " +
                   std::to_string(int(100 * kMinOverlap)) + " % or more (X_LR: maps points of the right camera into " +
                   "the left one)");
  }
}

}  // namespace gaitcam
