/// What a flat floor tells a walking camera of depth: the camera stays about as high above it as it was, so a feature
/// seen below the horizon has, if it lies on the floor, a known inverse depth. It keeps a monocular map's scale from
/// drifting, and gives new points a depth when the robot turns on the spot.
///
/// Assumes that the camera is carried roughly level: the floor's normal lies within 35 degrees of the camera's up.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/odometry/landmark_map.h"

namespace gaitcam {

class FloorGuess {
 public:
  /// Fits a plane to the known landmarks seen lately below the camera (RANSAC, then least squares). The first good
  /// plane fixes the camera's height for good; later ones follow the normal alone.
  void Update(const LandmarkMap& map, const Pose& X_WC, RandomStream& random);

  /// Inverse depth of a feature if it lies on the floor; nothing above or near the horizon, or where no floor was
  /// found.
  std::optional<DepthGuess> At(const Pose& X_WC, const Eigen::Vector2d& xy) const;

  /// Forgets the height: a new map has a new unit.
  void Clear() {
    height_.reset();
    heights_.clear();
  }

  std::optional<double> height() const { return height_; }  ///< Of the camera over the floor, in the map's unit.
  const Eigen::Vector3d& normal() const { return normal_W_; }

 private:
  std::optional<double> height_;
  std::vector<double> heights_;                         ///< Of the latest planes, until they agree.
  Eigen::Vector3d normal_W_ = Eigen::Vector3d::Zero();  ///< Up.
};

}  // namespace gaitcam
