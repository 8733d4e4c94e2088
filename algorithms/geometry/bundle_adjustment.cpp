#include "algorithms/geometry/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/inverse_depth.h"
#include "algorithms/geometry/levenberg_marquardt.h"
#include "algorithms/geometry/robust_loss.h"

namespace gaitcam {
namespace {

using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// Of the priors: observations may contradict them.
Loss CauchyLoss(double squared) { return {0.5 * std::log1p(squared), 1 / (1 + squared)}; }

/// Values of the unknowns.
struct BundleState {
  std::vector<Pose> cameras;
  std::vector<Eigen::Vector3d> points;  ///< Ray in the anchor, then inverse depth.
};

/// A change of all unknowns, and by how much the linearised problem's cost falls with it.
struct BundleStep {
  Eigen::VectorXd cameras;  ///< Six of each that is free, in the tangent of se3.h.
  std::vector<Eigen::Vector3d> points;
  double gain = 0;
};

/// Normal equations over cameras and points, of which the points are eliminated (Triggs et al., section 6.1).
class BundleEquations {
 public:
  BundleEquations(const BundleProblem& problem, const BundleOptions& options);

  double CostAt(const BundleState& state) const;
  /// @returns the cost there
  double Linearize(const BundleState& state);
  /// The step with each unknown's curvature enlarged by this part; nothing where that is singular.
  std::optional<BundleStep> Solve(double damping) const;
  BundleState Moved(const BundleState& state, const BundleStep& step) const;

 private:
  /// What a point and one of the free cameras that see it have in common.
  struct Link {
    int camera = 0;  ///< Among the free ones.
    Matrix63 H;
  };
  struct Point {
    std::vector<int> observations;
    std::vector<Link> links;  ///< By increasing camera.
    Eigen::Matrix3d H;
    Eigen::Vector3d g;
  };
  /// Rotations as matrices.
  struct Views {
    std::vector<Eigen::Matrix3d> R_WC;
    std::vector<InverseDepthCamera> cameras;
  };

  static Views ViewsOf(const BundleState& state);
  double PriorCost(size_t i, const Eigen::Vector3d& value) const;
  void AddPrior(size_t i, const Eigen::Vector3d& value);
  double AddObservation(const BundleObservation& observation, const BundleState& state, const Views& views);
  Link* LinkOf(Point& point, int camera) const;
  void AddBlocks(Point& point, int anchor, int camera, const Matrix26& J_anchor, const Matrix26& J_camera,
                 const Matrix23& J_point, const Eigen::Vector2d& residual, double weight);

  static constexpr double kBehind = 100;  ///< Standard deviations; constant, so that such a point has no pull.

  const BundleProblem& problem_;
  BundleOptions options_;
  std::vector<int> free_;  ///< Of each camera its number among the free ones; -1: fixed.
  int free_count_ = 0;
  std::vector<Point> points_;
  Eigen::MatrixXd H_;  ///< Of the free cameras; its lower triangle.
  Eigen::VectorXd g_;
};

BundleEquations::BundleEquations(const BundleProblem& problem, const BundleOptions& options)
    : problem_(problem), options_(options), points_(problem.points.size()) {
  for (const BundleCamera& camera : problem.cameras) free_.push_back(camera.fixed ? -1 : free_count_++);
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    const BundleObservation& observation = problem.observations[k];
    GAITCAM_ASSERT(problem.points[size_t(observation.point)].anchor != observation.camera && observation.sigma > 0);
    points_[size_t(observation.point)].observations.push_back(int(k));
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    GAITCAM_ASSERT(problem.points[i].prior_sigma > 0 && problem.points[i].sigma > 0);
    std::vector<int> seen_by = {free_[size_t(problem.points[i].anchor)]};
    for (const int k : points_[i].observations) {
      seen_by.push_back(free_[size_t(problem.observations[size_t(k)].camera)]);
    }
    std::sort(seen_by.begin(), seen_by.end());
    seen_by.erase(std::unique(seen_by.begin(), seen_by.end()), seen_by.end());
    for (const int camera : seen_by) {
      if (camera >= 0) points_[i].links.push_back({camera, Matrix63::Zero()});
    }
  }
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
  points_[i].H.diagonal() << information, information, weight / (point.prior_sigma * point.prior_sigma);
  points_[i].g << information * (value.head<2>() - point.xy), weight * depth / point.prior_sigma;
}

double BundleEquations::CostAt(const BundleState& state) const {
  const Views views = ViewsOf(state);
  double cost = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3d& value = state.points[i];
    const size_t anchor = size_t(problem_.points[i].anchor);
    cost += PriorCost(i, value);
    const AnchoredPoint seen(views.R_WC[anchor], state.cameras[anchor].translation, value.head<2>(), value.z());
    for (const int k : points_[i].observations) {
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
  H_ = Eigen::MatrixXd::Zero(6 * free_count_, 6 * free_count_);
  g_ = Eigen::VectorXd::Zero(6 * free_count_);
  double cost = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    points_[i].H.setZero();
    for (Link& link : points_[i].links) link.H.setZero();
    AddPrior(i, state.points[i]);
    cost += PriorCost(i, state.points[i]);
    for (const int k : points_[i].observations) {
      cost += AddObservation(problem_.observations[size_t(k)], state, views);
    }
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
  AddBlocks(points_[i], free_[anchor], free_[size_t(observation.camera)], J_anchor, J_camera, J_point, residual,
            loss.weight);
  return loss.cost;
}

BundleEquations::Link* BundleEquations::LinkOf(Point& point, int camera) const {
  if (camera < 0) return nullptr;
  return &*std::find_if(point.links.begin(), point.links.end(), [&](const Link& l) { return l.camera == camera; });
}

/// @param anchor, camera among the free ones; -1: fixed.
void BundleEquations::AddBlocks(Point& point, int anchor, int camera, const Matrix26& J_anchor,
                                const Matrix26& J_camera, const Matrix23& J_point, const Eigen::Vector2d& residual,
                                double weight) {
  const Eigen::Matrix<double, 6, 2> anchor_T = weight * J_anchor.transpose(), camera_T = weight * J_camera.transpose();
  const Eigen::Matrix<double, 3, 2> point_T = weight * J_point.transpose();
  point.H += point_T * J_point;
  point.g += point_T * residual;
  if (Link* const link = LinkOf(point, anchor)) {
    link->H += anchor_T * J_point;
    H_.block<6, 6>(6 * anchor, 6 * anchor) += anchor_T * J_anchor;
    g_.segment<6>(6 * anchor) += anchor_T * residual;
  }
  if (Link* const link = LinkOf(point, camera)) {
    link->H += camera_T * J_point;
    H_.block<6, 6>(6 * camera, 6 * camera) += camera_T * J_camera;
    g_.segment<6>(6 * camera) += camera_T * residual;
  }
  if (anchor < 0 || camera < 0) return;
  if (camera > anchor) {
    H_.block<6, 6>(6 * camera, 6 * anchor) += camera_T * J_anchor;
  } else {
    H_.block<6, 6>(6 * anchor, 6 * camera) += anchor_T * J_camera;
  }
}

std::optional<BundleStep> BundleEquations::Solve(double damping) const {
  constexpr double kLeastCurvature = 1e-6;
  const auto extra = [&](const auto& diagonal) { return (damping * diagonal.cwiseMax(kLeastCurvature)).eval(); };
  const Eigen::VectorXd extra_cameras = extra(H_.diagonal());
  Eigen::MatrixXd S = H_;  // Schur's complement, the lower triangle
  S.diagonal() += extra_cameras;
  Eigen::VectorXd right = -g_;
  std::vector<Eigen::Matrix3d> inverses(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    Eigen::Matrix3d H = point.H;
    H.diagonal() += extra(point.H.diagonal());
    inverses[i] = H.inverse();
    for (size_t a = 0; a < point.links.size(); ++a) {
      const Matrix63 W = point.links[a].H * inverses[i];
      right.segment<6>(6 * point.links[a].camera) += W * point.g;
      for (size_t b = 0; b <= a; ++b) {
        S.block<6, 6>(6 * point.links[a].camera, 6 * point.links[b].camera).noalias() -=
            W * point.links[b].H.transpose();
      }
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factors(S);
  if (factors.info() != Eigen::Success) return {};
  BundleStep step{factors.solve(right), {}, 0};
  step.gain = 0.5 * (step.cameras.dot(extra_cameras.cwiseProduct(step.cameras)) - g_.dot(step.cameras));
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    Eigen::Vector3d sum = point.g;
    for (const Link& link : point.links) sum += link.H.transpose() * step.cameras.segment<6>(6 * link.camera);
    const Eigen::Vector3d change = -inverses[i] * sum;
    step.gain += 0.5 * (change.dot(extra(point.H.diagonal()).cwiseProduct(change)) - point.g.dot(change));
    step.points.push_back(change);
  }
  if (!step.cameras.allFinite() || !(step.gain > 0)) return {};
  return step;
}

BundleState BundleEquations::Moved(const BundleState& state, const BundleStep& step) const {
  BundleState moved = state;
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) moved.cameras[k] = Plus(state.cameras[k], step.cameras.segment<6>(6 * free_[k]));
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
