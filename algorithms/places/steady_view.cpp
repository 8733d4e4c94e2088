#include "algorithms/places/steady_view.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {
namespace {

/// 0 for a frame on both feet throughout, 1 for one on a single foot.
double SingleSupportShare(const Observation& observation) {
  const auto both = std::count_if(observation.joints.begin(), observation.joints.end(),
                                  [](const JointSample& s) { return s.left_contact && s.right_contact; });
  return 1 - double(both) / double(observation.joints.size());
}

/// The greatest angular rate sensed while the shutter was open, rad/s.
double MaxAngularRate(const Observation& observation) {
  double fastest = 0;
  const double open_ns = 0.5e6 * observation.exposure_ms + 1e7;
  for (const ImuSample& sample : observation.imu) {
    if (std::abs(double(sample.stamp_ns - observation.stamp_ns)) <= open_ns)
      fastest = std::max(fastest, sample.angular_rate.norm());
  }
  return fastest;
}

double Unrest(const Observation& observation, Steadiness steadiness) {
  switch (steadiness) {
    case Steadiness::kDoubleSupport: return observation.joints.empty() ? 0 : SingleSupportShare(observation);
    case Steadiness::kGyro: return MaxAngularRate(observation);
    case Steadiness::kLast: return 0;
  }
  return 0;
}

}  // namespace

std::optional<SteadyView> SteadyViewPicker::Add(const Observation& observation, const Eigen::Vector3d& up_C,
                                                double heading_rad) {
  const double unrest = Unrest(observation, steadiness_);
  if (!best_ || best_unrest_ >= unrest) {
    best_ = SteadyView{observation.image.pixels.clone(), up_C, observation.stamp_ns, heading_rad};
    best_unrest_ = unrest;
  }
  if (returned_ns_ < 0) returned_ns_ = observation.stamp_ns;
  if (double(observation.stamp_ns - returned_ns_) * 1e-9 < interval_s_) return std::nullopt;
  returned_ns_ = observation.stamp_ns;
  std::optional<SteadyView> picked;
  picked.swap(best_);
  return picked;
}

void SteadyViewPicker::Reset() {
  best_.reset();
  returned_ns_ = -1;
}

}  // namespace gaitcam
