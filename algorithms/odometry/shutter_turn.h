/// How a camera turned while its rolling shutter went down the image, by the gyroscope: a key point is seen when its
/// row is exposed, up to half the readout before or after the frame's stamp, and a pose is of the stamp.
///
/// Rotation only. A head that walks turns by some 20 px within a readout of 20 ms, and moves by one or two.

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
  /// @param readout_ms first to last row, > 0; the frame's stamp is that of the row in the middle
  /// @returns nothing where the gyroscope did not measure it
  static std::optional<ShutterTurn> Measure(const GyroTurn& gyro, int64_t stamp_ns, double readout_ms);

  /// Where a point would have been seen, had all rows been exposed at the stamp.
  /// @param xy  where it was seen, undistorted normalised image coordinates
  /// @param row 0: in the first row, 1: in the last
  Eigen::Vector2d AtStamp(const Eigen::Vector2d& xy, double row) const;

 private:
  ShutterTurn() = default;

  std::vector<Eigen::Vector3d> turns_;  ///< phi of R_ST = Exp(phi), S at the stamp, T when a row was exposed; evenly
                                        ///< spaced rows, the first and the last among them.
};

}  // namespace gaitcam
