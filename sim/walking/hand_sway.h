/// How a camera moves in the hand of somebody who walks: up and down with every step, to and fro with every second one,
/// and slowly astray, because nobody holds a camera still.

#pragma once

#include <cstdint>
#include <vector>

#include "models/code/robots/robot.h"

namespace gaitcam {

class HandSway {
 public:
  /// @param speed_mps at which its carrier walks: people keep the length of a step over the rate of steps, so the rate
  /// is sqrt(speed / Robot::walk_ratio_m_s). @param seed of where the hand wanders. A robot without sway has none.
  HandSway(const Robot& robot, double speed_mps, uint64_t seed);

  /// Adds to the targets of the robot's joints (order of Robot::joints) what they are off by.
  /// @param time_s of walking. @param speed_ratio of the full speed: there are no steps at 0.
  void AddTo(std::vector<double>& targets, double time_s, double speed_ratio) const;

  double step_rate_hz() const { return step_rate_hz_; }

 private:
  struct Wave {
    double frequency_hz, phase_rad, amplitude;
  };
  struct Joint {
    size_t index;
    SwayOptions options;
    std::vector<Wave> wander;
  };

  double step_rate_hz_ = 0;
  std::vector<Joint> joints_;
};

}  // namespace gaitcam
