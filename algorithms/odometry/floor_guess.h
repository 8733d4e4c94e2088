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

/// normal . p + height = 0 for points p of the camera's frame; the normal points up, the camera is `height` above.
struct FloorPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double height = 0;
};

/// The level plane that most points lie on and next to none below (RANSAC, then least squares).
/// @param points in the camera's frame, all below its centre (y > 0)
/// @returns nothing if fewer than 40 points agree.
std::optional<FloorPlane> FindFloor(const std::vector<Eigen::Vector3d>& points, RandomStream& random);

class FloorGuess {
 public:
  /// Looks for the floor among the known landmarks seen lately below the camera. The first one found fixes the camera's
  /// height for good; later ones follow the normal alone.
  void Update(const LandmarkMap& map, const Pose& X_WC, RandomStream& random);

  /// Inverse depth of a feature if it lies on the floor; nothing above or near the horizon, where no floor was found,
  /// or where something known stands before it: a wall's foot hides what is behind it.
  std::optional<DepthGuess> At(const Pose& X_WC, const Eigen::Vector2d& xy) const;

  /// Forgets the height: a new map has a new unit.
  void Clear() {
    height_.reset();
    standing_.clear();
  }

  std::optional<double> height() const { return height_; }  ///< Of the camera over the floor, in the map's unit.
  const Eigen::Vector3d& normal() const { return normal_W_; }

 private:
  void FindStanding(const LandmarkMap& map, const Pose& X_WC);
  bool IsHidden(const Pose& X_WC, const Eigen::Vector3d& floor_point_W) const;

  std::optional<double> height_;
  Eigen::Vector3d normal_W_ = Eigen::Vector3d::Zero();  ///< Up.
  std::vector<Eigen::Vector3d> standing_;               ///< Known places well above the floor, in W.
};

}  // namespace gaitcam
