/// How a walking camera goes on: at the mean velocity of about the last second. Over a few steps swaying and bobbing
/// cancel out.
///
/// A prior of the next position that is centred on the last one says that the camera stands still. Where landmarks tell
/// the length of a step badly, as when a wall whose depth is not known yet fills the view, each step then comes out a
/// little too short, new landmarks get their depths by these steps, and the map's unit shrinks for good. A prior
/// centred on where the camera will probably be is not biased so.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "algorithms/core/trajectory.h"

namespace gaitcam {

class MeanVelocity {
 public:
  /// The next pose in the same map. After more than half a second without one the velocity is unknown again.
  void Add(const StampedPose& X_WC);

  /// Another map, another unit: the velocity is unknown, taken as zero until poses tell it.
  void Reset() {
    last_.reset();
    velocity_W_.setZero();
  }

  /// How far the camera goes in `apart_ns` after the last pose, in the map's unit and frame; no farther than in half a
  /// second.
  Eigen::Vector3d Advance(int64_t apart_ns) const;

 private:
  std::optional<StampedPose> last_;
  Eigen::Vector3d velocity_W_ = Eigen::Vector3d::Zero();  ///< Map units per second.
};

}  // namespace gaitcam
