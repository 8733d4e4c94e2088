#include "algorithms/geometry/stereo_bundle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/levenberg_marquardt.h"
#include "algorithms/geometry/point_elimination.h"
#include "algorithms/geometry/rig_projection.h"
#include "algorithms/geometry/robust_loss.h"

namespace gaitcam {
namespace {

struct RigBundleState {
  Pose X_LR;
  std::vector<Pose> cameras;
  std::vector<Eigen::Vector3d> points;
};

class RigBundleEquations {
 public:
  RigBundleEquations(const StereoBundleProblem& problem, const StereoBundleOptions& options);

  double CostAt(const RigBundleState& state) const;
  double Linearize(const RigBundleState& state);
  std::optional<PosePointStep> Solve(double damping) const { return SolvePosesAndPoints(equations_, damping); }
  RigBundleState Moved(const RigBundleState& state, const PosePointStep& step) const;

  /// At the state that was linearised last.
  void FillCovariances(StereoBundleResult& result) const;
  std::vector<Matrix6d> OwnCovariances(const RigBundleState& state) const;
  std::vector<double> Errors2(const RigBundleState& state) const;

 private:
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

  static constexpr double kBehind2 = 1e4;  ///< Squared length of a residual of a point behind its camera; no pull.

  const StereoBundleProblem& problem_;
  StereoBundleOptions options_;
  std::vector<int> free_;  ///< Of each camera its number among the free poses; -1: fixed.
  int rig_ = -1;           ///< Number of the rig's pose; -1: fixed.
  int poses_ = 0;
  Matrix6d whiten_prior_ = Matrix6d::Zero();
  std::vector<Eigen::Matrix2d> whiten_;  ///< W with W' W = covariance^-1.
  PosePointEquations equations_;         ///< Poses are the free cameras', then the rig's.
};

RigBundleEquations::RigBundleEquations(const StereoBundleProblem& problem, const StereoBundleOptions& options)
    : problem_(problem), options_(options) {
  for (const StereoBundleCamera& camera : problem.cameras) free_.push_back(camera.fixed ? -1 : poses_++);
  if (!problem.prior_covariance.isZero(0)) {
    rig_ = poses_++;
    whiten_prior_ = Whitening(problem.prior_covariance);
  }
  std::vector<std::vector<int>> seen_by(problem.points.size());
  for (const StereoBundleObservation& observation : problem.observations) {
    std::vector<int>& poses = seen_by[size_t(observation.point)];
    poses.push_back(free_[size_t(observation.camera)]);
    if (observation.right) poses.push_back(rig_);
    whiten_.push_back(Whitening(observation.covariance));
  }
  equations_ = PosePointEquations(std::move(seen_by));
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
  equations_.SetZero(poses_);
  double cost = 0.5 * PriorResidual(state).squaredNorm();
  if (rig_ >= 0) AddPrior(state);
  for (size_t k = 0; k < problem_.observations.size(); ++k) cost += AddObservation(k, state, views);
  return cost;
}

/// The rig's tangent differs from its prior's by little: the Jacobian of Minus is taken as the identity.
void RigBundleEquations::AddPrior(const RigBundleState& state) {
  equations_.H.block<6, 6>(6 * rig_, 6 * rig_) += whiten_prior_.transpose() * whiten_prior_;
  equations_.g.segment<6>(6 * rig_) += whiten_prior_.transpose() * PriorResidual(state);
}

/// @returns its cost
double RigBundleEquations::AddObservation(size_t k, const RigBundleState& state, const Views& views) {
  const StereoBundleObservation& observation = problem_.observations[k];
  EliminatedPoint& point = equations_.points[size_t(observation.point)];
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
    equations_.g.segment<6>(6 * pose) += J.transpose() * weighted;
    equations_.H.block<6, 6>(6 * pose, 6 * pose) += J.transpose() * J;
    point.Find(pose)->H += J.transpose() * J_point;
  }
  if (blocks[0].first >= 0 && blocks[1].first >= 0) {
    equations_.H.block<6, 6>(6 * rig_, 6 * blocks[0].first) += blocks[1].second.transpose() * blocks[0].second;
  }
  return loss.cost;
}

RigBundleState RigBundleEquations::Moved(const RigBundleState& state, const PosePointStep& step) const {
  RigBundleState moved = state;
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) moved.cameras[k] = Plus(state.cameras[k], step.poses.segment<6>(6 * free_[k]));
  }
  if (rig_ >= 0) moved.X_LR = Plus(state.X_LR, step.poses.segment<6>(6 * rig_));
  for (size_t i = 0; i < step.points.size(); ++i) moved.points[i] += step.points[i];
  return moved;
}

void RigBundleEquations::FillCovariances(StereoBundleResult& result) const {
  PosePointCovariances covariances = CovariancesOf(equations_);
  result.camera_covariances.assign(free_.size(), Matrix6d::Zero());
  result.point_covariances = std::move(covariances.points);
  result.has_covariance = covariances.poses.size() > 0;
  if (!result.has_covariance) return;
  const auto of_pose = [&](int pose) { return covariances.poses.block<6, 6>(6 * pose, 6 * pose); };
  for (size_t k = 0; k < free_.size(); ++k) {
    if (free_[k] >= 0) result.camera_covariances[k] = of_pose(free_[k]);
  }
  if (rig_ >= 0) result.rig_covariance = of_pose(rig_);
}

std::vector<Matrix6d> RigBundleEquations::OwnCovariances(const RigBundleState& state) const {
  const Views views = ViewsOf(state);
  std::vector<int> seen_by(state.points.size(), -1);
  std::vector<bool> shared(state.points.size(), false);
  for (const StereoBundleObservation& observation : problem_.observations) {
    int& camera = seen_by[size_t(observation.point)];
    if (camera < 0) camera = observation.camera;
    if (camera != observation.camera) shared[size_t(observation.point)] = true;
  }
  std::vector<Matrix6d> information(state.cameras.size(), Matrix6d::Zero());
  for (size_t k = 0; k < problem_.observations.size(); ++k) {
    const StereoBundleObservation& observation = problem_.observations[k];
    if (!shared[size_t(observation.point)]) continue;
    const auto sight = ProjectInRig(views.X_CW[size_t(observation.camera)], observation.right ? &views.X_RL : nullptr,
                                    state.points[size_t(observation.point)]);
    if (!sight) continue;
    const double error2 = (whiten_[k] * (sight->xy - observation.xy)).squaredNorm();
    const Eigen::Matrix<double, 2, 6> J = whiten_[k] * sight->by_camera;
    information[size_t(observation.camera)] += HuberLoss(error2, options_.huber).weight * J.transpose() * J;
  }
  for (Matrix6d& block : information) {
    const Eigen::LLT<Matrix6d> factors(block);
    block = factors.info() == Eigen::Success ? Matrix6d(factors.solve(Matrix6d::Identity())) : Matrix6d::Zero();
  }
  return information;
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
  result.own_covariances = equations.OwnCovariances(state);
  result.errors2 = equations.Errors2(state);
  problem.X_LR = state.X_LR;
  problem.points = state.points;
  for (size_t k = 0; k < state.cameras.size(); ++k) problem.cameras[k].X_WC = state.cameras[k];
  return result;
}

}  // namespace gaitcam
