#include "algorithms/odometry/mean_velocity.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {
namespace {

constexpr double kMean_s = 1;     // time constant of the mean
constexpr double kTrust_s = 0.5;  // a velocity says nothing of later

}  // namespace

void MeanVelocity::Add(const StampedPose& X_WC) {
  const double apart_s = last_ ? 1e-9 * double(X_WC.stamp_ns - last_->stamp_ns) : 0;
  if (!last_ || apart_s > kTrust_s) {
    velocity_W_.setZero();
  } else if (apart_s > 0) {
    const Eigen::Vector3d now_W = (X_WC.pose.translation - last_->pose.translation) / apart_s;
    velocity_W_ += (1 - std::exp(-apart_s / kMean_s)) * (now_W - velocity_W_);
  }
  last_ = X_WC;
}

Eigen::Vector3d MeanVelocity::Advance(int64_t apart_ns) const {
  return std::min(kTrust_s, 1e-9 * double(apart_ns)) * velocity_W_;
}

}  // namespace gaitcam
