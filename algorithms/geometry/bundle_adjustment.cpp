#include "algorithms/geometry/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/inverse_depth.h"

namespace gaitcam {
namespace {

/// A pose's parameters: quaternion x y z w, then translation.
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

/// X + (rho, phi) = X Exp(rho, phi). Cost functions give their derivative by (rho, phi) in the first six columns, which
/// the identity below hands on.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    const PoseBlock block = ToBlock(gaitcam::Plus(ToPose(x), Eigen::Map<const Vector6d>(delta)));
    std::copy(block.begin(), block.end(), sum);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRows<6>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    Eigen::Map<Vector6d> tau(difference);
    tau = gaitcam::Minus(ToPose(y), ToPose(x));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.leftCols<6>().setIdentity();
    return true;
  }
};

/// A point's parameters: its ray in the anchor, then its inverse depth.
using PointBlock = Eigen::Vector3d;

/// Reprojection error, in standard deviations.
class SightingError : public ceres::SizedCostFunction<2, 7, 7, 3> {
 public:
  explicit SightingError(const BundleObservation& observation) : xy_(observation.xy), weight_(1 / observation.sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const PointBlock> point(parameters[2]);
    const auto projection =
        LinearizeInverseDepth(ToPose(parameters[0]), point.head<2>(), point.z(), ToPose(parameters[1]));
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    constexpr double kBehind = 100;  // standard deviations; constant, so that such a point has no pull
    residual = projection ? Eigen::Vector2d(weight_ * (projection->xy - xy_)) : Eigen::Vector2d::Constant(kBehind);
    if (!jacobians) return true;
    for (int k = 0; k < 2; ++k) {
      if (!jacobians[k]) continue;
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> J(jacobians[k]);
      J.setZero();
      if (projection) J.leftCols<6>() = weight_ * (k == 0 ? projection->d_anchor : projection->d_camera);
    }
    if (jacobians[2]) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J(jacobians[2]);
      J.setZero();
      if (projection) J << weight_ * projection->d_xy, weight_ * projection->d_rho;
    }
    return true;
  }

 private:
  Eigen::Vector2d xy_;
  double weight_;
};

/// Reprojection error in the anchor.
class AnchorError : public ceres::SizedCostFunction<2, 3> {
 public:
  explicit AnchorError(const BundlePoint& point) : xy_(point.xy), weight_(1 / point.sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = weight_ * (Eigen::Map<const Eigen::Vector2d>(parameters[0]) - xy_);
    if (jacobians && jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J(jacobians[0]);
      J << weight_, 0, 0, 0, weight_, 0;
    }
    return true;
  }

 private:
  Eigen::Vector2d xy_;
  double weight_;
};

/// Prior of the inverse depth.
class DepthPrior : public ceres::SizedCostFunction<1, 3> {
 public:
  explicit DepthPrior(const BundlePoint& point) : rho_(point.prior_rho), weight_(1 / point.prior_sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (parameters[0][2] - rho_);
    if (jacobians && jacobians[0]) Eigen::Map<Eigen::RowVector3d>(jacobians[0]) << 0, 0, weight_;
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
  solver.function_tolerance = 1e-6;
  return solver;
}

/// Standard deviations of the inverse depths, the cameras held fixed: 1 / sqrt(sum of squared derivatives).
void EstimateDepthSigmas(BundleProblem& problem) {
  std::vector<double> information;
  for (const BundlePoint& point : problem.points) information.push_back(1 / (point.prior_sigma * point.prior_sigma));
  for (const BundleObservation& observation : problem.observations) {
    const BundlePoint& point = problem.points[size_t(observation.point)];
    const auto projection = LinearizeInverseDepth(problem.cameras[size_t(point.anchor)].X_WC, point.ray, point.rho,
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
  ceres::CauchyLoss cauchy(1);  // the prior is robust: observations may contradict it
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t i = 0; i < poses.size(); ++i) {
    ceres_problem.AddParameterBlock(poses[i].data(), 7, &manifold);
    if (problem.cameras[i].fixed) ceres_problem.SetParameterBlockConstant(poses[i].data());
    ordering->AddElementToGroup(poses[i].data(), 1);
  }
  std::vector<PointBlock> points;
  for (const BundlePoint& point : problem.points) points.emplace_back(point.ray.x(), point.ray.y(), point.rho);
  for (size_t i = 0; i < points.size(); ++i) {
    GAITCAM_ASSERT(problem.points[i].prior_sigma > 0 && problem.points[i].sigma > 0);
    ceres_problem.AddResidualBlock(new AnchorError(problem.points[i]), nullptr, points[i].data());
    ceres_problem.AddResidualBlock(new DepthPrior(problem.points[i]), &cauchy, points[i].data());
    ordering->AddElementToGroup(points[i].data(), 0);
  }
  for (const BundleObservation& observation : problem.observations) {
    const int anchor = problem.points[size_t(observation.point)].anchor;
    GAITCAM_ASSERT(anchor != observation.camera && observation.sigma > 0);
    ceres_problem.AddResidualBlock(new SightingError(observation), &huber, poses[size_t(anchor)].data(),
                                   poses[size_t(observation.camera)].data(), points[size_t(observation.point)].data());
  }
  ceres::Solver::Options solver = SolverOptions(options);
  solver.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  for (size_t i = 0; i < poses.size(); ++i) problem.cameras[i].X_WC = ToPose(poses[i].data());
  for (size_t i = 0; i < points.size(); ++i) {
    problem.points[i].ray = points[i].head<2>();
    problem.points[i].rho = points[i].z();
  }
  EstimateDepthSigmas(problem);
  return {summary.initial_cost, summary.final_cost};
}

}  // namespace gaitcam
