#include "algorithms/geometry/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/inverse_depth.h"
#include "algorithms/geometry/levenberg_marquardt.h"
#include "algorithms/geometry/point_elimination.h"
#include "algorithms/geometry/robust_loss.h"

namespace gaitcam {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// Of the priors: observations may contradict them.
Loss CauchyLoss(double squared) { return {0.5 * std::log1p(squared), 1 / (1 + squared)}; }

/// Values of the unknowns.
struct BundleState {
  std::vector<Pose> cameras;
  std::vector<Eigen::Vector3d> points;  ///< Ray in the anchor, then inverse depth.
};

/// Normal equations over cameras and points.
class BundleEquations {
 public:
  BundleEquations(const BundleProblem& problem, const BundleOptions& options);

  double CostAt(const BundleState& state) const;
  /// @returns the cost there
  double Linearize(const BundleState& state);
  std::optional<PosePointStep> Solve(double damping) const { return SolvePosesAndPoints(equations_, damping); }
  BundleState Moved(const BundleState& state, const PosePointStep& step) const;

 private:
  /// Rotations as matrices.
  struct Views {
    std::vector<Eigen::Matrix3d> R_WC;
    std::vector<InverseDepthCamera> cameras;
  };

  static Views ViewsOf(const BundleState& state);
  double PriorCost(size_t i, const Eigen::Vector3d& value) const;
  void AddPrior(size_t i, const Eigen::Vector3d& value);
  double AddObservation(const BundleObservation& observation, const BundleState& state, const Views& views);
  void AddBlocks(EliminatedPoint& point, int anchor, int camera, const Matrix26& J_anchor, const Matrix26& J_camera,
                 const Matrix23& J_point, const Eigen::Vector2d& residual, double weight);

  static constexpr double kBehind = 100;  ///< Standard deviations; constant, so that such a point has no pull.

  const BundleProblem& problem_;
  BundleOptions options_;
  std::vector<int> free_;  ///< Of each camera its number among the free ones; -1: fixed.
  int free_count_ = 0;
  std::vector<std::vector<int>> observations_;  ///< Of each point.
  PosePointEquations equations_;                ///< Poses are the free cameras'.
};

BundleEquations::BundleEquations(const BundleProblem& problem, const BundleOptions& options)
    : problem_(problem), options_(options), observations_(problem.points.size()) {
  for (const BundleCamera& camera : problem.cameras) free_.push_back(camera.fixed ? -1 : free_count_++);
  std::vector<std::vector<int>> seen_by;
  for (const BundlePoint& point : problem.points) {
    GAITCAM_ASSERT(point.prior_sigma > 0 && point.sigma > 0);
    seen_by.push_back({free_[size_t(point.anchor)]});
  }
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    const BundleObservation& observation = problem.observations[k];
    const size_t i = size_t(observation.point);
    GAITCAM_ASSERT(problem.points[i].anchor != observation.camera && observation.sigma > 0);
    observations_[i].push_back(int(k));
    seen_by[i].push_back(free_[size_t(observation.camera)]);
  }
  equations_ = PosePointEquations(std::move(seen_by));
}

BundleEquations::Views BundleEquations::ViewsOf(const BundleState& state) {
  Views views;
  for (const Pose& X_WC : state.cameras) {
    views.R_WC.push_back(X_WC.R());
    views.cameras.emplace_back(X_WC);
  }
  return views;
}

/// Of the measurement in the anchor and of the inverse depth's prior.
double BundleEquations::PriorCost(size_t i, const Eigen::Vector3d& value) const {
  const BundlePoint& point = problem_.points[i];
  const double depth = (value.z() - point.prior_rho) / point.prior_sigma;
  return 0.5 * (value.head<2>() - point.xy).squaredNorm() / (point.sigma * point.sigma) +
         CauchyLoss(depth * depth).cost;
}

void BundleEquations::AddPrior(size_t i, const Eigen::Vector3d& value) {
  const BundlePoint& point = problem_.points[i];
  const double information = 1 / (point.sigma * point.sigma);
  const double depth = (value.z() - point.prior_rho) / point.prior_sigma;
  const double weight = CauchyLoss(depth * depth).weight;
  equations_.points[i].H.diagonal() << information, information, weight / (point.prior_sigma * point.prior_sigma);
  equations_.points[i].g << information * (value.head<2>() - point.xy), weight * depth / point.prior_sigma;
}

double BundleEquations::CostAt(const BundleState& state) const {
  const Views views = ViewsOf(state);
  double cost = 0;
  for (size_t i = 0; i < observations_.size(); ++i) {
    const Eigen::Vector3d& value = state.points[i];
    const size_t anchor = size_t(problem_.points[i].anchor);
    cost += PriorCost(i, value);
    const AnchoredPoint seen(views.R_WC[anchor], state.cameras[anchor].translation, value.head<2>(), value.z());
    for (const int k : observations_[i]) {
      const BundleObservation& observation = problem_.observations[size_t(k)];
      const auto xy = views.cameras[size_t(observation.camera)].Project(seen);
      const double squared =
          xy ? (*xy - observation.xy).squaredNorm() / (observation.sigma * observation.sigma) : 2 * kBehind * kBehind;
      cost += HuberLoss(squared, options_.huber).cost;
    }
  }
  return cost;
}

double BundleEquations::Linearize(const BundleState& state) {
  const Views views = ViewsOf(state);
  equations_.SetZero(free_count_);
  double cost = 0;
  for (size_t i = 0; i < observations_.size(); ++i) {
    AddPrior(i, state.points[i]);
    cost += PriorCost(i, state.points[i]);
    for (const int k : observations_[i]) cost += AddObservation(problem_.observations[size_t(k)], state, views);
  }
  return cost;
}

/// Reprojection error, in standard deviations. @returns its cost
double BundleEquations::AddObservation(const BundleObservation& observation, const BundleState& state,
                                       const Views& views) {
  const size_t i = size_t(observation.point), anchor = size_t(problem_.points[i].anchor);
  const Eigen::Vector3d& value = state.points[i];
  const Eigen::Matrix3d& R_WA = views.R_WC[anchor];
  const InverseDepthCamera& camera = views.cameras[size_t(observation.camera)];
  const auto sight = camera.See({R_WA, state.cameras[anchor].translation, value.head<2>(), value.z()});
  if (!sight) return HuberLoss(2 * kBehind * kBehind, options_.huber).cost;
  const double scale = 1 / observation.sigma;
  const Eigen::Vector2d residual = scale * (sight->xy - observation.xy);
  const Loss loss = HuberLoss(residual.squaredNorm(), options_.huber);
  const Matrix23 by_ray = scale * (sight->d_xy * (camera.R_CW() * R_WA));
  Matrix26 J_anchor, J_camera = scale * sight->DerivativeByCamera(value.z());
  J_anchor << value.z() * by_ray, -by_ray * Hat({value.x(), value.y(), 1});
  Matrix23 J_point;
  J_point << by_ray.leftCols<2>(), scale * sight->d_rho;
  AddBlocks(equations_.points[i], free_[anchor], free_[size_t(observation.camera)], J_anchor, J_camera, J_point,
            residual, loss.weight);
  return loss.cost;
}

/// @param anchor, camera among the free ones; -1: fixed.
void BundleEquations::AddBlocks(EliminatedPoint& point, int anchor, int camera, const Matrix26& J_anchor,
                                const Matrix26& J_camera, const Matrix23& J_point, const Eigen::Vector2d& residual,
                                double weight) {
  const Eigen::Matrix<double, 6, 2> anchor_T = weight * J_anchor.transpose(), camera_T = weight * J_camera.transpose();
  const Eigen::Matrix<double, 3, 2> point_T = weight * J_point.transpose();
  point.H += point_T * J_point;
  point.g += point_T * residual;
  if (PosePointLink* const link = point.Find(anchor)) {
    link->H += anchor_T * J_point;
    equations_.H.block<6, 6>(6 * anchor, 6 * anchor) += anchor_T * J_anchor;
    equations_.g.segment<6>(6 * anchor) += anchor_T * residual;
  }
  if (PosePointLink* const link = point.Find(camera)) {
    link->H += camera_T * J_point;
    equations_.H.block<6, 6>(6 * camera, 6 * camera) += camera_T * J_camera;
    equations_.g.segment<6>(6 * camera) += camera_T * residual;
  }
  if (anchor < 0 || camera < 0) return;
  if (camera > anchor) {
    equations_.H.block<6, 6>(6 * camera, 6 * anchor) += camera_T * J_anchor;
  } else {
    equations_.H.block<6, 6>(6 * anchor, 6 * camera) += anchor_T * J_camera;
  }
}

BundleState BundleEquations::Moved(const BundleState& state, const PosePointStep& step) const {
  BundleState moved = state;
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) moved.cameras[k] = Plus(state.cameras[k], step.poses.segment<6>(6 * free_[k]));
  }
  for (size_t i = 0; i < step.points.size(); ++i) moved.points[i] += step.points[i];
  return moved;
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
  BundleState state;
  for (const BundleCamera& camera : problem.cameras) state.cameras.push_back(camera.X_WC);
  for (const BundlePoint& point : problem.points) state.points.emplace_back(point.ray.x(), point.ray.y(), point.rho);
  BundleEquations equations(problem, options);
  const LevenbergMarquardtResult result = MinimizeLevenbergMarquardt(equations, options.max_iterations, state);
  for (size_t k = 0; k < state.cameras.size(); ++k) problem.cameras[k].X_WC = state.cameras[k];
  for (size_t i = 0; i < state.points.size(); ++i) {
    problem.points[i].ray = state.points[i].head<2>();
    problem.points[i].rho = state.points[i].z();
  }
  EstimateDepthSigmas(problem);
  return {result.cost_before, result.cost_after};
}

}  // namespace gaitcam
