/// The rotations of an odometry's frames by image and gyroscope together (RotationChain), and from which rotation each
/// image was seen: a blurred one shows the camera as it was at some instant of the exposure.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
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

  /// What the present frame's image says, once for every frame; nothing: it has no pose.
  /// @param begins the map is another one than the frame's before
  void Add(const RotationChain::Rotation& R_WC, bool begins);

  /// Of the present frame, by its image and all that was before; nothing where no image has told any yet.
  const RotationChain::Rotation& Present() const { return rotation_; }

  /// From which the present image was seen: of the rotations over the exposure, by Present() and the gyroscope, the one
  /// nearest to what the image says.
  /// @pre the present frame has a pose
  Eigen::Quaterniond SeenFrom();

  /// Rotations by all images and all turns.
  /// @param frames all of them, their poses as SeenFrom() had them, moved along with the map since
  void Smooth(std::vector<FrameEstimate>& frames) const;

 private:
  double noise_density_;  ///< rad/s/sqrt(Hz)
  GyroTurn gyro_;         ///< Told of no bias.
  ExposureMotion exposure_;
  RotationChain chain_;
  FrameTurn turn_;                        ///< Of the present frame.
  RotationChain::Rotation rotation_;      ///< Likewise.
  std::optional<int64_t> last_ns_;        ///< The frame before.
  std::vector<Eigen::Quaterniond> said_;  ///< Of each frame what its image says, against where it was seen from.
  RotationChain::Rotation image_;         ///< What the present one says.
};

}  // namespace gaitcam
