#include "algorithms/geometry/shutter_turn.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {

namespace {

/// phi of R_ST = Exp(phi); S is the camera at the stamp, T so long after it.
std::optional<Eigen::Vector3d> TurnFromStamp(const GyroTurn& gyro, int64_t stamp_ns, double after_ms) {
  const int64_t at_ns = stamp_ns + std::llround(after_ms * kNsPerMs);
  if (at_ns == stamp_ns) return Eigen::Vector3d::Zero();
  const auto turn = gyro.Between(std::min(at_ns, stamp_ns), std::max(at_ns, stamp_ns));
  if (!turn || at_ns > stamp_ns) return turn;
  return Eigen::Vector3d(-*turn);  // it is from the earlier instant to the later one
}

}  // namespace

std::optional<ShutterTurn> ShutterTurn::Measure(const GyroTurn& gyro, int64_t stamp_ns, double readout_ms) {
  constexpr int kRows = 9;  // a turn hardly changes its rate within an eighth of a readout
  ShutterTurn shutter;
  double measured_ms = -0.5 * readout_ms;
  for (int i = 0; i < kRows; ++i) {
    const double after_ms = readout_ms * (double(i) / (kRows - 1) - 0.5);
    if (const auto turn = TurnFromStamp(gyro, stamp_ns, after_ms)) {
      shutter.turns_.push_back(*turn);
      if (after_ms != 0) measured_ms = after_ms;
    } else if (i >= 2 && after_ms - measured_ms <= kMaxExtrapolated_ms) {
      shutter.turns_.push_back(2 * shutter.turns_[size_t(i) - 1] - shutter.turns_[size_t(i) - 2]);
    } else {
      return {};
    }
  }
  return shutter;
}

Eigen::Vector2d ShutterTurn::AtStamp(const Eigen::Vector2d& xy, double row) const {
  return (R_ST(row) * xy.homogeneous()).hnormalized();
}

Eigen::Quaterniond ShutterTurn::R_ST(double row) const {
  const int intervals = int(turns_.size()) - 1;
  const double at = std::clamp(row, 0.0, 1.0) * intervals;
  const int before = std::min(int(at), intervals - 1);
  const Eigen::Vector3d turn =
      turns_[size_t(before)] + (at - before) * (turns_[size_t(before) + 1] - turns_[size_t(before)]);
  return ExpSo3(turn);
}

}  // namespace gaitcam
