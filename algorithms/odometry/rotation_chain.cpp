#include "algorithms/odometry/rotation_chain.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

/// No rotation is known.
RotationChain::State RotationChain::First() const {
  State first;
  first.covariance = Matrix6d::Zero();
  first.covariance.diagonal().tail<3>().setConstant(bias_sigma_ * bias_sigma_);
  return first;
}

/// Of the errors, from the frame before to this one.
Matrix6d RotationChain::Transition(const Link& link) {
  Matrix6d transition = Matrix6d::Identity();
  if (!link.frame.turn) return transition;
  transition.topLeftCorner<3, 3>() = ExpSo3(-*link.frame.turn).toRotationMatrix();
  transition.topRightCorner<3, 3>().diagonal().setConstant(-link.frame.seconds);
  return transition;
}

/// Where the turn was not measured, or the map is another, the bias alone is known further.
RotationChain::State RotationChain::Turned(const State& before, const Link& link) const {
  State after = before;
  const Matrix6d transition = Transition(link);
  after.covariance = transition * before.covariance * transition.transpose();
  after.covariance.diagonal().head<3>().array() += link.frame.sigma * link.frame.sigma;
  after.covariance.diagonal().tail<3>().array() += bias_walk_ * bias_walk_ * link.frame.seconds;
  if (before.R_WC && link.frame.turn && !link.begins) {
    after.R_WC = (*before.R_WC * ExpSo3(*link.frame.turn - link.frame.seconds * before.bias)).normalized();
    return after;
  }
  after.R_WC.reset();
  after.covariance.topRows<3>().setZero();
  after.covariance.leftCols<3>().setZero();
  return after;
}

RotationChain::State RotationChain::Updated(const State& predicted, const Link& link, const Rotation& R_WC) {
  if (!R_WC) return predicted;
  State updated = predicted;
  if (!predicted.R_WC) {
    updated.R_WC = R_WC;
    updated.covariance.topLeftCorner<3, 3>() = link.frame.spread;
    return updated;
  }
  constexpr double kUsual = 3;  // standard deviations
  const Eigen::Vector3d excess = LogSo3(predicted.R_WC->conjugate() * *R_WC);
  const Eigen::Matrix3d own = predicted.covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d expected = own + link.frame.spread;
  const double distance = std::sqrt(excess.dot(expected.ldlt().solve(excess)));
  const Eigen::Matrix3d innovation = own + std::max(1.0, distance / kUsual) * link.frame.spread;
  const Eigen::Matrix<double, 6, 3> gain = innovation.ldlt().solve(predicted.covariance.topRows<3>()).transpose();
  const Vector6d change = gain * excess;
  updated.R_WC = (*predicted.R_WC * ExpSo3(change.head<3>())).normalized();
  updated.bias += change.tail<3>();
  const Matrix6d covariance = predicted.covariance - gain * predicted.covariance.topRows<3>();
  updated.covariance = 0.5 * (covariance + covariance.transpose());
  return updated;
}

RotationChain::Rotation RotationChain::Add(const FrameTurn& frame, const Rotation& R_WC, bool begins) {
  links_.push_back({frame, begins});
  latest_ = Updated(Turned(latest_.value_or(First()), links_.back()), links_.back(), R_WC);
  return latest_->R_WC;
}

RotationChain::Rotation RotationChain::Predict(const FrameTurn& next) const {
  return latest_ ? Turned(*latest_, {next, false}).R_WC : std::nullopt;
}

std::vector<RotationChain::Rotation> RotationChain::Smoothed(const std::vector<Rotation>& R_WC) const {
  GAITCAM_ASSERT(R_WC.size() == links_.size());
  const size_t n = links_.size();
  std::vector<State> predicted, smoothed;  // the latter filtered at first
  for (size_t k = 0; k < n; ++k) {
    predicted.push_back(Turned(k > 0 ? smoothed.back() : First(), links_[k]));
    smoothed.push_back(Updated(predicted.back(), links_[k], R_WC[k]));
  }
  std::vector<Rotation> rotations(n);
  for (size_t k = n; k-- > 0;) {
    State& state = smoothed[k];
    if (k + 1 < n && predicted[k + 1].R_WC) {
      const State& next = predicted[k + 1];
      Vector6d change;
      change << LogSo3(next.R_WC->conjugate() * *smoothed[k + 1].R_WC), smoothed[k + 1].bias - next.bias;
      const Matrix6d gain = next.covariance.ldlt().solve(Transition(links_[k + 1]) * state.covariance).transpose();
      const Vector6d step = gain * change;
      state.R_WC = (*state.R_WC * ExpSo3(step.head<3>())).normalized();
      state.bias += step.tail<3>();
    }
    rotations[k] = state.R_WC;
  }
  return rotations;
}

}  // namespace gaitcam
