#include "algorithms/geometry/gyro_turn.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/se3.h"

namespace gaitcam {

void GyroTurn::Add(const std::vector<ImuSample>& samples) {
  samples_.insert(samples_.end(), samples.begin(), samples.end());
}

void GyroTurn::DropBefore(int64_t stamp_ns) {
  const auto old = [&](const ImuSample& sample) { return sample.stamp_ns < stamp_ns; };
  samples_.erase(samples_.begin(), std::find_if_not(samples_.begin(), samples_.end(), old));
}

std::optional<Eigen::Vector3d> GyroTurn::Between(int64_t from_ns, int64_t to_ns) const {
  constexpr double kMinCoverage = 0.7;
  const double half_period_ns = 0.5e9 / imu_.rate_hz, span_ns = double(to_ns - from_ns);
  Eigen::Quaterniond R_FT = Eigen::Quaterniond::Identity();
  double covered_ns = 0;
  for (const ImuSample& sample : samples_) {
    const double stamp_ns = double(sample.stamp_ns - from_ns);  // from here on, since the first instant
    const double begin = std::max(0.0, stamp_ns - half_period_ns);
    const double end = std::min(span_ns, stamp_ns + half_period_ns);
    if (end <= begin) continue;
    covered_ns += end - begin;
    const Eigen::Vector3d rate_C = imu_.X_CI.rotation * sample.angular_rate - bias_;
    R_FT = R_FT * ExpSo3(rate_C * (end - begin) * 1e-9);
  }
  if (covered_ns < kMinCoverage * span_ns) return std::nullopt;
  return LogSo3(R_FT) * (span_ns / covered_ns);
}

void GyroTurn::LearnBias(const Eigen::Vector3d& excess_rad, double time_s, double sigma_rad) {
  const double variance = std::pow(sigma_rad / time_s, 2), prior = std::pow(bias_sigma_, 2);
  const double gain = prior / (prior + variance);
  bias_ += gain / time_s * excess_rad;
  bias_sigma_ = std::sqrt((1 - gain) * prior);
}

}  // namespace gaitcam
