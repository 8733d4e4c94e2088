#include "algorithms/geometry/stereo_bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/levenberg_marquardt.h"
#include "algorithms/geometry/rig_projection.h"
#include "algorithms/geometry/robust_loss.h"

namespace gaitcam {
namespace {

using Matrix63 = Eigen::Matrix<double, 6, 3>;

struct RigBundleState {
  Pose X_LR;
  std::vector<Pose> cameras;
  std::vector<Eigen::Vector3d> points;
};

struct RigBundleStep {
  Eigen::VectorXd poses;  ///< Six of each free camera, then six of the rig if it is free.
  std::vector<Eigen::Vector3d> points;
  double gain = 0;
};

class RigBundleEquations {
 public:
  RigBundleEquations(const StereoBundleProblem& problem, const StereoBundleOptions& options);

  double CostAt(const RigBundleState& state) const;
  double Linearize(const RigBundleState& state);
  std::optional<RigBundleStep> Solve(double damping) const;
  RigBundleState Moved(const RigBundleState& state, const RigBundleStep& step) const;

  /// At the state that was linearised last.
  void FillCovariances(StereoBundleResult& result) const;
  std::vector<double> Errors2(const RigBundleState& state) const;

 private:
  /// What a point and a free pose have in common.
  struct Link {
    int pose = 0;
    Matrix63 H;
  };
  struct Point {
    std::vector<Link> links;  ///< By increasing pose.
    Eigen::Matrix3d H;
    Eigen::Vector3d g;
  };
  /// Inverses of the poses, and the rig's.
  struct Views {
    std::vector<Pose> X_CW;
    Pose X_RL;
  };

  static Views ViewsOf(const RigBundleState& state);
  Vector6d PriorResidual(const RigBundleState& state) const;
  std::optional<Eigen::Vector2d> Residual(size_t k, const RigBundleState& state, const Views& views) const;
  double AddObservation(size_t k, const RigBundleState& state, const Views& views);
  void AddPrior(const RigBundleState& state);
  Eigen::MatrixXd Reduced(double damping, Eigen::VectorXd& right, std::vector<Eigen::Matrix3d>& inverses) const;

  static constexpr double kBehind2 = 1e4;  ///< Squared length of a residual of a point behind its camera; no pull.
  static constexpr double kLeastCurvature = 1e-6;

  const StereoBundleProblem& problem_;
  StereoBundleOptions options_;
  std::vector<int> free_;  ///< Of each camera its number among the free poses; -1: fixed.
  int rig_ = -1;           ///< Number of the rig's pose; -1: fixed.
  int poses_ = 0;
  Matrix6d whiten_prior_ = Matrix6d::Zero();
  std::vector<Eigen::Matrix2d> whiten_;  ///< W with W' W = covariance^-1.
  std::vector<Point> points_;
  Eigen::MatrixXd H_;  ///< Of the free poses; its lower triangle.
  Eigen::VectorXd g_;
};

RigBundleEquations::RigBundleEquations(const StereoBundleProblem& problem, const StereoBundleOptions& options)
    : problem_(problem), options_(options), points_(problem.points.size()) {
  for (const StereoBundleCamera& camera : problem.cameras) free_.push_back(camera.fixed ? -1 : poses_++);
  if (!problem.prior_covariance.isZero(0)) {
    rig_ = poses_++;
    whiten_prior_ = Whitening(problem.prior_covariance);
  }
  std::vector<std::vector<int>> seen_by(points_.size());
  for (const StereoBundleObservation& observation : problem.observations) {
    std::vector<int>& poses = seen_by[size_t(observation.point)];
    if (free_[size_t(observation.camera)] >= 0) poses.push_back(free_[size_t(observation.camera)]);
    if (observation.right && rig_ >= 0) poses.push_back(rig_);
    whiten_.push_back(Whitening(observation.covariance));
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    std::sort(seen_by[i].begin(), seen_by[i].end());
    seen_by[i].erase(std::unique(seen_by[i].begin(), seen_by[i].end()), seen_by[i].end());
    for (const int pose : seen_by[i]) points_[i].links.push_back({pose, Matrix63::Zero()});
  }
}

RigBundleEquations::Views RigBundleEquations::ViewsOf(const RigBundleState& state) {
  Views views;
  for (const Pose& X_WC : state.cameras) views.X_CW.push_back(X_WC.Inverse());
  views.X_RL = state.X_LR.Inverse();
  return views;
}

/// Of the rig, in standard deviations.
Vector6d RigBundleEquations::PriorResidual(const RigBundleState& state) const {
  if (rig_ < 0) return Vector6d::Zero();
  return whiten_prior_ * Minus(state.X_LR, problem_.prior_X_LR);
}

/// In standard deviations; nothing if the point lies behind the camera.
std::optional<Eigen::Vector2d> RigBundleEquations::Residual(size_t k, const RigBundleState& state,
                                                            const Views& views) const {
  const StereoBundleObservation& observation = problem_.observations[k];
  Eigen::Vector3d p = views.X_CW[size_t(observation.camera)] * state.points[size_t(observation.point)];
  if (observation.right) p = views.X_RL * p;
  if (p.z() <= kLeastDepth) return {};
  return (whiten_[k] * (p.hnormalized() - observation.xy)).eval();
}

double RigBundleEquations::CostAt(const RigBundleState& state) const {
  const Views views = ViewsOf(state);
  double cost = 0.5 * PriorResidual(state).squaredNorm();
  for (size_t k = 0; k < problem_.observations.size(); ++k) {
    const auto residual = Residual(k, state, views);
    cost += HuberLoss(residual ? residual->squaredNorm() : kBehind2, options_.huber).cost;
  }
  return cost;
}

std::vector<double> RigBundleEquations::Errors2(const RigBundleState& state) const {
  const Views views = ViewsOf(state);
  std::vector<double> errors2;
  for (size_t k = 0; k < problem_.observations.size(); ++k) {
    const auto residual = Residual(k, state, views);
    errors2.push_back(residual ? residual->squaredNorm() : kBehind2);
  }
  return errors2;
}

double RigBundleEquations::Linearize(const RigBundleState& state) {
  const Views views = ViewsOf(state);
  H_ = Eigen::MatrixXd::Zero(6 * poses_, 6 * poses_);
  g_ = Eigen::VectorXd::Zero(6 * poses_);
  for (Point& point : points_) {
    point.H.setZero();
    point.g.setZero();
    for (Link& link : point.links) link.H.setZero();
  }
  double cost = 0.5 * PriorResidual(state).squaredNorm();
  if (rig_ >= 0) AddPrior(state);
  for (size_t k = 0; k < problem_.observations.size(); ++k) cost += AddObservation(k, state, views);
  return cost;
}

/// The rig's tangent differs from its prior's by little: the Jacobian of Minus is taken as the identity.
void RigBundleEquations::AddPrior(const RigBundleState& state) {
  H_.block<6, 6>(6 * rig_, 6 * rig_) += whiten_prior_.transpose() * whiten_prior_;
  g_.segment<6>(6 * rig_) += whiten_prior_.transpose() * PriorResidual(state);
}

/// @returns its cost
double RigBundleEquations::AddObservation(size_t k, const RigBundleState& state, const Views& views) {
  const StereoBundleObservation& observation = problem_.observations[k];
  Point& point = points_[size_t(observation.point)];
  const auto sight = ProjectInRig(views.X_CW[size_t(observation.camera)], observation.right ? &views.X_RL : nullptr,
                                  state.points[size_t(observation.point)]);
  if (!sight) return HuberLoss(kBehind2, options_.huber).cost;
  const Eigen::Vector2d residual = whiten_[k] * (sight->xy - observation.xy);
  const Loss loss = HuberLoss(residual.squaredNorm(), options_.huber);
  const Eigen::Matrix2d W = std::sqrt(loss.weight) * whiten_[k];
  const Eigen::Vector2d weighted = std::sqrt(loss.weight) * residual;
  const Eigen::Matrix<double, 2, 3> J_point = W * sight->by_point;
  point.H += J_point.transpose() * J_point;
  point.g += J_point.transpose() * weighted;
  std::array<std::pair<int, Eigen::Matrix<double, 2, 6>>, 2> blocks = {
      std::pair{free_[size_t(observation.camera)], (W * sight->by_camera).eval()},
      std::pair{observation.right ? rig_ : -1, (W * sight->by_rig).eval()}};
  for (const auto& [pose, J] : blocks) {
    if (pose < 0) continue;
    g_.segment<6>(6 * pose) += J.transpose() * weighted;
    H_.block<6, 6>(6 * pose, 6 * pose) += J.transpose() * J;
    const auto link =
        std::find_if(point.links.begin(), point.links.end(), [&](const Link& l) { return l.pose == pose; });
    link->H += J.transpose() * J_point;
  }
  if (blocks[0].first >= 0 && blocks[1].first >= 0) {
    H_.block<6, 6>(6 * rig_, 6 * blocks[0].first) += blocks[1].second.transpose() * blocks[0].second;
  }
  return loss.cost;
}

/// Schur's complement, the lower triangle, and the right-hand side that belongs to it.
Eigen::MatrixXd RigBundleEquations::Reduced(double damping, Eigen::VectorXd& right,
                                            std::vector<Eigen::Matrix3d>& inverses) const {
  const auto extra = [&](const auto& diagonal) { return (damping * diagonal.cwiseMax(kLeastCurvature)).eval(); };
  Eigen::MatrixXd S = H_;
  S.diagonal() += extra(H_.diagonal());
  right = -g_;
  inverses.resize(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    Eigen::Matrix3d H = point.H;
    H.diagonal() += extra(point.H.diagonal());
    inverses[i] = H.inverse();
    for (size_t a = 0; a < point.links.size(); ++a) {
      const Matrix63 W = point.links[a].H * inverses[i];
      right.segment<6>(6 * point.links[a].pose) += W * point.g;
      for (size_t b = 0; b <= a; ++b) {
        S.block<6, 6>(6 * point.links[a].pose, 6 * point.links[b].pose).noalias() -= W * point.links[b].H.transpose();
      }
    }
  }
  return S;
}

std::optional<RigBundleStep> RigBundleEquations::Solve(double damping) const {
  Eigen::VectorXd right;
  std::vector<Eigen::Matrix3d> inverses;
  const Eigen::LLT<Eigen::MatrixXd> factors(Reduced(damping, right, inverses));
  if (factors.info() != Eigen::Success) return {};
  const auto extra = [&](const auto& diagonal) { return (damping * diagonal.cwiseMax(kLeastCurvature)).eval(); };
  RigBundleStep step{factors.solve(right), {}, 0};
  step.gain = 0.5 * (step.poses.dot(extra(H_.diagonal()).cwiseProduct(step.poses)) - g_.dot(step.poses));
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    Eigen::Vector3d sum = point.g;
    for (const Link& link : point.links) sum += link.H.transpose() * step.poses.segment<6>(6 * link.pose);
    const Eigen::Vector3d change = -inverses[i] * sum;
    step.gain += 0.5 * (change.dot(extra(point.H.diagonal()).cwiseProduct(change)) - point.g.dot(change));
    step.points.push_back(change);
  }
  if (!step.poses.allFinite() || !(step.gain > 0)) return {};
  return step;
}

RigBundleState RigBundleEquations::Moved(const RigBundleState& state, const RigBundleStep& step) const {
  RigBundleState moved = state;
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) moved.cameras[k] = Plus(state.cameras[k], step.poses.segment<6>(6 * free_[k]));
  }
  if (rig_ >= 0) moved.X_LR = Plus(state.X_LR, step.poses.segment<6>(6 * rig_));
  for (size_t i = 0; i < step.points.size(); ++i) moved.points[i] += step.points[i];
  return moved;
}

void RigBundleEquations::FillCovariances(StereoBundleResult& result) const {
  Eigen::VectorXd right;
  std::vector<Eigen::Matrix3d> inverses;
  const Eigen::LLT<Eigen::MatrixXd> factors(Reduced(0, right, inverses));
  result.camera_covariances.assign(free_.size(), Matrix6d::Zero());
  result.point_covariances = std::move(inverses);
  if (poses_ == 0 || factors.info() != Eigen::Success) return;
  const Eigen::MatrixXd covariance = factors.solve(Eigen::MatrixXd::Identity(6 * poses_, 6 * poses_));
  if (!covariance.allFinite()) return;
  result.has_covariance = true;
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) result.camera_covariances[k] = covariance.block<6, 6>(6 * free_[k], 6 * free_[k]);
  }
  if (rig_ >= 0) result.rig_covariance = covariance.block<6, 6>(6 * rig_, 6 * rig_);
}

}  // namespace

StereoBundleResult AdjustStereoBundle(StereoBundleProblem& problem, const StereoBundleOptions& options) {
  RigBundleState state{problem.X_LR, {}, problem.points};
  for (const StereoBundleCamera& camera : problem.cameras) state.cameras.push_back(camera.X_WC);
  RigBundleEquations equations(problem, options);
  const LevenbergMarquardtResult minimum = MinimizeLevenbergMarquardt(equations, options.max_iterations, state);
  equations.Linearize(state);
  StereoBundleResult result;
  result.cost_before = minimum.cost_before;
  result.cost_after = minimum.cost_after;
  equations.FillCovariances(result);
  result.errors2 = equations.Errors2(state);
  problem.X_LR = state.X_LR;
  problem.points = state.points;
  for (size_t k = 0; k < state.cameras.size(); ++k) problem.cameras[k].X_WC = state.cameras[k];
  return result;
}

}  // namespace gaitcam
