#include "algorithms/geometry/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <array>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/inverse_depth.h"

namespace gaitcam {
namespace {

/// Seven numbers as Ceres sees a pose: quaternion x y z w, then translation.
using PoseBlock = std::array<double, 7>;

Pose ToPose(const double* block) {
  Pose pose;
  pose.rotation = Eigen::Map<const Eigen::Quaterniond>(block);
  pose.translation = Eigen::Map<const Eigen::Vector3d>(block + 4);
  return pose;
}

PoseBlock ToBlock(const Pose& pose) {
  PoseBlock block;
  Eigen::Map<Eigen::Quaterniond>(block.data()) = pose.rotation;
  Eigen::Map<Eigen::Vector3d>(block.data() + 4) = pose.translation;
  return block;
}

/// (R, t) + (w, v) = (R exp([w]x), t + v). Cost functions give their derivative by (w, v) in the first six columns,
/// which the identity below hands on.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    const Eigen::Map<const Eigen::Vector3d> w(delta), v(delta + 3);
    const double angle = w.norm();
    const Eigen::AngleAxisd turn(angle, angle > 0 ? Eigen::Vector3d(w / angle) : Eigen::Vector3d::UnitX());
    Eigen::Map<Eigen::Quaterniond> q(sum);
    q = (Eigen::Map<const Eigen::Quaterniond>(x) * Eigen::Quaterniond(turn)).normalized();
    Eigen::Map<Eigen::Vector3d>(sum + 4) = Eigen::Map<const Eigen::Vector3d>(x + 4) + v;
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRows<6>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    const Eigen::Quaterniond turn =
        Eigen::Map<const Eigen::Quaterniond>(x).conjugate() * Eigen::Map<const Eigen::Quaterniond>(y);
    const Eigen::AngleAxisd axis(turn);
    Eigen::Map<Eigen::Vector3d> w(difference), v(difference + 3);
    w = axis.angle() * axis.axis();
    v = Eigen::Map<const Eigen::Vector3d>(y + 4) - Eigen::Map<const Eigen::Vector3d>(x + 4);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.leftCols<6>().setIdentity();
    return true;
  }
};

/// Distance between where a camera sees a point and where it should, in standard deviations.
class SightingError : public ceres::SizedCostFunction<2, 7, 7, 1> {
 public:
  SightingError(const Eigen::Vector2d& anchor_xy, const BundleObservation& observation)
      : anchor_xy_(anchor_xy), xy_(observation.xy), weight_(1 / observation.sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto projection =
        LinearizeInverseDepth(ToPose(parameters[0]), anchor_xy_, parameters[2][0], ToPose(parameters[1]));
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    constexpr double kBehind = 100;  // standard deviations: far beyond what Huber trusts, and flat
    residual = projection ? Eigen::Vector2d(weight_ * (projection->xy - xy_)) : Eigen::Vector2d::Constant(kBehind);
    if (!jacobians) return true;
    using PoseJacobian = Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>>;
    for (int k = 0; k < 2; ++k) {
      if (!jacobians[k]) continue;
      PoseJacobian J(jacobians[k]);
      J.setZero();
      if (projection) J.leftCols<6>() = weight_ * (k == 0 ? projection->d_anchor : projection->d_camera);
    }
    if (jacobians[2]) {
      Eigen::Map<Eigen::Vector2d> J(jacobians[2]);
      J = projection ? Eigen::Vector2d(weight_ * projection->d_rho) : Eigen::Vector2d::Zero();
    }
    return true;
  }

 private:
  Eigen::Vector2d anchor_xy_, xy_;
  double weight_;
};

/// What is thought of an inverse depth beforehand.
class DepthPrior : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit DepthPrior(const BundlePoint& point) : rho_(point.prior_rho), weight_(1 / point.prior_sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (parameters[0][0] - rho_);
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double rho_, weight_;
};

ceres::Solver::Options SolverOptions(const BundleOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;  // sums in one order: the same bits on every run
  solver.logging_type = ceres::SILENT;
  solver.function_tolerance = 1e-5;
  return solver;
}

/// Standard deviations of the inverse depths, the cameras held fixed: 1 / sqrt(sum of squared derivatives).
void EstimateDepthSigmas(BundleProblem& problem) {
  std::vector<double> information;
  for (const BundlePoint& point : problem.points) information.push_back(1 / (point.prior_sigma * point.prior_sigma));
  for (const BundleObservation& observation : problem.observations) {
    const BundlePoint& point = problem.points[size_t(observation.point)];
    const auto projection = LinearizeInverseDepth(problem.cameras[size_t(point.anchor)].X_WC, point.xy, point.rho,
                                                  problem.cameras[size_t(observation.camera)].X_WC);
    if (!projection) continue;
    information[size_t(observation.point)] += projection->d_rho.squaredNorm() / (observation.sigma * observation.sigma);
  }
  for (size_t i = 0; i < information.size(); ++i) problem.points[i].rho_sigma = 1 / std::sqrt(information[i]);
}

}  // namespace

BundleResult AdjustBundle(BundleProblem& problem, const BundleOptions& options) {
  std::vector<PoseBlock> poses;
  for (const BundleCamera& camera : problem.cameras) poses.push_back(ToBlock(camera.X_WC));
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  PoseManifold manifold;
  ceres::HuberLoss huber(options.huber);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t i = 0; i < poses.size(); ++i) {
    ceres_problem.AddParameterBlock(poses[i].data(), 7, &manifold);
    if (problem.cameras[i].fixed) ceres_problem.SetParameterBlockConstant(poses[i].data());
    ordering->AddElementToGroup(poses[i].data(), 1);
  }
  for (BundlePoint& point : problem.points) {
    GAITCAM_ASSERT(point.prior_sigma > 0);
    ceres_problem.AddResidualBlock(new DepthPrior(point), nullptr, &point.rho);
    ordering->AddElementToGroup(&point.rho, 0);
  }
  for (const BundleObservation& observation : problem.observations) {
    BundlePoint& point = problem.points[size_t(observation.point)];
    GAITCAM_ASSERT(point.anchor != observation.camera && observation.sigma > 0);
    ceres_problem.AddResidualBlock(new SightingError(point.xy, observation), &huber, poses[size_t(point.anchor)].data(),
                                   poses[size_t(observation.camera)].data(), &point.rho);
  }
  ceres::Solver::Options solver = SolverOptions(options);
  solver.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  for (size_t i = 0; i < poses.size(); ++i) problem.cameras[i].X_WC = ToPose(poses[i].data());
  EstimateDepthSigmas(problem);
  return {summary.initial_cost, summary.final_cost};
}

}  // namespace gaitcam
