#include "sim/walking/hand_sway.h"

#include <cmath>

#include "algorithms/core/random.h"
#include "algorithms/core/units.h"

namespace gaitcam {

HandSway::HandSway(const Robot& robot, double speed_mps, uint64_t seed) {
  if (robot.sway.empty()) return;
  step_rate_hz_ = std::sqrt(speed_mps / robot.walk_ratio_m_s);
  constexpr int kWaves = 12;
  for (const SwayOptions& options : robot.sway) {
    Joint joint{size_t(robot.FindJoint(options.joint)), options, {}};
    RandomStream random(seed, "sway." + options.joint);
    for (int i = 0; i < kWaves; ++i) {  // a sum of waves has the wanted variance, whatever their phases
      const double frequency_hz = options.wander_hz * random.Uniform(0.05, 1.0);
      joint.wander.push_back({frequency_hz, random.Uniform(0, 2 * kPi), options.wander * std::sqrt(2.0 / kWaves)});
    }
    joints_.push_back(joint);
  }
}

void HandSway::AddTo(std::vector<double>& targets, double time_s, double speed_ratio) const {
  for (const Joint& joint : joints_) {
    const SwayOptions& o = joint.options;
    const double phase = 2 * kPi * o.per_step * step_rate_hz_ * time_s + o.phase_deg * kRadPerDeg;
    double offset = speed_ratio * o.amplitude * std::sin(phase);
    for (const Wave& wave : joint.wander)
      offset += wave.amplitude * std::sin(2 * kPi * wave.frequency_hz * time_s + wave.phase_rad);
    targets[joint.index] += offset;
  }
}

}  // namespace gaitcam
