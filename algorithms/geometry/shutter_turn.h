/// Correction of a rolling shutter by the gyroscope: a point is seen when its row is exposed, up to half the readout
/// before or after the frame's stamp, and a pose is of the stamp.
///
/// Rotation alone, as in Karpenko, Jacobs, Baek and Levoy, Stanford CSTR 2011-03: how far the camera moves within a
/// readout needs the points' depths, and is left to those who know them.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/geometry/gyro_turn.h"

namespace gaitcam {

class ShutterTurn {
 public:
  /// The longest time after the last measured turn for which the camera is taken to turn on at the same rate. A frame
  /// of a short exposure has been read out before the gyroscope's last samples are there.
  static constexpr double kMaxExtrapolated_ms = 10;

  /// @param readout_ms first to last row, > 0; the frame's stamp is that of the row in the middle
  /// @returns nothing where the gyroscope did not measure it
  static std::optional<ShutterTurn> Measure(const GyroTurn& gyro, int64_t stamp_ns, double readout_ms);

  /// Where a point would have been seen, had all rows been exposed at the stamp.
  /// @param xy  where it was seen, undistorted normalised image coordinates
  /// @param row 0: in the first row, 1: in the last
  Eigen::Vector2d AtStamp(const Eigen::Vector2d& xy, double row) const;
  /// R_ST: S is the camera at the stamp, T when that row was exposed.
  Eigen::Quaterniond R_ST(double row) const;

 private:
  ShutterTurn() = default;

  /// phi of R_ST = Exp(phi), rad; S is the camera at the stamp, T when a row was exposed. Of evenly spaced rows, from
  /// the first to the last.
  std::vector<Eigen::Vector3d> turns_;
};

}  // namespace gaitcam
