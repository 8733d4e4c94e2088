/// The rotations of an odometry's frames by image and gyroscope together (RotationChain). The poses in its map stay the
/// images' alone: what an image shows is seen from where the image says, whichever instant of the exposure that was.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/gyro_turn.h"
#include "algorithms/odometry/exposure_motion.h"
#include "algorithms/odometry/rotation_chain.h"

namespace gaitcam {

class FusedRotations {
 public:
  explicit FusedRotations(const ImuCalibration& imu);

  /// The next frame, before its pose is looked for.
  void Begin(const Observation& observation);

  /// Of the present frame, by all that was before; nothing where the gyroscope did not measure.
  RotationChain::Rotation Predicted() const;

  /// @param answer to the present frame; the rotation of its pose, if it has one, becomes that by image and gyroscope.
  void Fuse(FrameEstimate& answer);

  /// Rotations by all images and all turns.
  /// @param frames all of them, their poses as the images say in the end
  void Smooth(std::vector<FrameEstimate>& frames) const;

 private:
  double noise_density_;  ///< rad/s/sqrt(Hz)
  GyroTurn gyro_;         ///< Told of no bias.
  ExposureMotion exposure_;
  RotationChain chain_;
  FrameTurn present_;
  std::optional<int64_t> last_ns_;  ///< The frame before.
};

}  // namespace gaitcam
