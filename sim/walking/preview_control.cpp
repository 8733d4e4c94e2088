#include "sim/walking/preview_control.h"

#include <cmath>
#include <numeric>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// The stabilising solution P of  P = A' P A - A' P b (R + b' P b)^-1 b' P A + Q,  by iteration to a fixed point.
Eigen::Matrix4d SolveRiccati(const Eigen::Matrix4d& a, const Eigen::Vector4d& b, const Eigen::Matrix4d& q, double r) {
  constexpr int kMaxIterations = 200000;
  constexpr double kConverged = 1e-10;  // relative change per iteration; rounding alone leaves some 1e-13
  Eigen::Matrix4d p = q;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::RowVector4d bpa = b.transpose() * p * a;
    const Eigen::Matrix4d next = a.transpose() * p * a - bpa.transpose() * bpa / (r + b.dot(p * b)) + q;
    const double change = (next - p).norm() / p.norm();
    p = next;
    if (change < kConverged) return p;
  }
  throw BadOption("preview control: no gains for this height and period: the Riccati iteration does not converge");
}

}  // namespace

PreviewControl::PreviewControl(const PreviewOptions& options) : com_height_m_(options.com_height_m) {
  if (!(options.com_height_m > 0) || !(options.period_s > 0) || !(options.horizon_s > options.period_s)) {
    throw BadOption("preview control: height, period and horizon must be positive, the horizon longer than the period");
  }
  const double t = options.period_s;
  transition_ << 1, t, t * t / 2, 0, 1, t, 0, 0, 1;
  input_ << t * t * t / 6, t * t / 2, t;
  output_ << 1, 0, -options.com_height_m / kGravity;

  // The servo system (eq. 10): its state is the ZMP error and the increments of x, its input the increment of u.
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  a(0, 0) = 1;
  a.block<1, 3>(0, 1) = output_ * transition_;
  a.block<3, 3>(1, 1) = transition_;
  Eigen::Vector4d b;
  b << output_ * input_, input_;
  Eigen::Matrix4d q = Eigen::Matrix4d::Zero();
  q(0, 0) = options.tracking_weight;

  const Eigen::Matrix4d p = SolveRiccati(a, b, q, options.jerk_weight);
  const double scale = options.jerk_weight + b.dot(p * b);
  const Eigen::RowVector4d gain = b.transpose() * p * a / scale;
  integral_gain_ = gain(0);
  state_gain_ = gain.tail<3>();

  // G_d(1) = -G_i and G_d(j) = (R + b'Pb)^-1 b' X(j-1) with X(j) = (A - bK)' X(j-1): the closed loop run backwards.
  const Eigen::Matrix4d closed_loop = (a - b * gain).transpose();
  Eigen::Vector4d x = -closed_loop * p.col(0);
  preview_gains_.resize(size_t(std::lround(options.horizon_s / t)));
  preview_gains_[0] = -integral_gain_;
  for (size_t j = 1; j < preview_gains_.size(); ++j) {
    preview_gains_[j] = b.dot(x) / scale;
    x = closed_loop * x;
  }
  // All gains to infinity add up to -G_x(1): a cart that rests over its reference stays there, wherever that is.
  preview_gains_.back() -= state_gain_(0) + std::accumulate(preview_gains_.begin(), preview_gains_.end(), 0.0);
}

void PreviewControl::Reset(const Eigen::Vector2d& position) {
  state_.setZero();
  state_.row(0) = position.transpose();
  error_sum_.setZero();
}

void PreviewControl::Update(const std::vector<Eigen::Vector2d>& zmp_reference) {
  GAITCAM_ASSERT(int(zmp_reference.size()) >= reference_count());
  error_sum_ += output_ * state_ - zmp_reference[0].transpose();
  Eigen::RowVector2d jerk = -integral_gain_ * error_sum_ - state_gain_ * state_;
  for (size_t j = 0; j < preview_gains_.size(); ++j) jerk -= preview_gains_[j] * zmp_reference[j + 1].transpose();
  state_ = transition_ * state_ + input_ * jerk;
}

double PreviewControl::natural_frequency() const { return std::sqrt(kGravity / com_height_m_); }

}  // namespace gaitcam
