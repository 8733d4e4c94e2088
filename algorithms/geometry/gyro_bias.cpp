#include "algorithms/geometry/gyro_bias.h"

#include <numbers>

namespace gaitcam {
namespace {

constexpr double kMaxBias_rad_s = 3 * std::numbers::pi / 180;  ///< rad/s; ten times the bias of a cheap one.
constexpr int kMinSamples = 100;                               ///< Samples; half a second at 200 Hz.

}  // namespace

void GyroBias::Stand(const std::vector<ImuSample>& samples) {
  for (const ImuSample& sample : samples) {
    ++seen_;
    if ((sample.angular_rate - bias_).norm() > kMaxBias_rad_s) continue;
    sum_ += sample.angular_rate;
    ++counted_;
  }
}

void GyroBias::Learn() {
  if (counted_ >= kMinSamples && 2 * counted_ > seen_) {
    bias_ = sum_ / counted_;
    learned_ = true;
  }
  sum_.setZero();
  counted_ = seen_ = 0;
}

}  // namespace gaitcam
