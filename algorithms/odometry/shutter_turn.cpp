#include "algorithms/odometry/shutter_turn.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {

std::optional<ShutterTurn> ShutterTurn::Measure(const GyroTurn& gyro, int64_t stamp_ns, double readout_ms) {
  constexpr int kRows = 9;  // a turn hardly changes its rate within an eighth of a readout
  ShutterTurn shutter;
  for (int i = 0; i < kRows; ++i) {
    const double after_ms = readout_ms * (double(i) / (kRows - 1) - 0.5);
    const int64_t at_ns = stamp_ns + std::llround(after_ms * kNsPerMs);
    if (at_ns == stamp_ns) {
      shutter.turns_.push_back(Eigen::Vector3d::Zero());
      continue;
    }
    const auto turn = gyro.Between(std::min(at_ns, stamp_ns), std::max(at_ns, stamp_ns));
    if (!turn) return {};
    shutter.turns_.push_back(
        at_ns > stamp_ns ? *turn : Eigen::Vector3d(-*turn));  // it is from the earlier instant to the later one
  }
  return shutter;
}

Eigen::Vector2d ShutterTurn::AtStamp(const Eigen::Vector2d& xy, double row) const {
  const int intervals = int(turns_.size()) - 1;
  const double at = std::clamp(row, 0.0, 1.0) * intervals;
  const int before = std::min(int(at), intervals - 1);
  const Eigen::Vector3d turn =
      turns_[size_t(before)] + (at - before) * (turns_[size_t(before) + 1] - turns_[size_t(before)]);
  return (ExpSo3(turn) * xy.homogeneous()).hnormalized();
}

}  // namespace gaitcam
