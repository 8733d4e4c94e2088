/// Prior of a feature's inverse depth from a flat floor: a walking camera's height above it is nearly constant, so a
/// feature below the horizon has, if it lies on the floor, a known inverse depth. This limits the scale drift of a
/// monocular map, and gives new landmarks a depth when the robot turns on the spot.
///
/// Where gravity is known, the floor is the one that MetricScale measures with it. Elsewhere it is fitted to the
/// landmarks alone, and the camera is assumed to be carried roughly level: the floor's normal lies within 35 degrees of
/// its up.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/odometry/keyframe_map.h"
#include "algorithms/odometry/metric_scale.h"

namespace gaitcam {

/// normal . p + height = 0 for points p in the camera's frame; the unit normal points up, the camera is `height` above.
struct FloorPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double height = 0;
};

/// The level plane with most inliers and next to no points below it, by RANSAC and least squares.
/// @param points in the camera's frame, all below its centre (y > 0)
/// @returns nothing if it has fewer than 40 inliers.
std::optional<FloorPlane> FindFloor(const std::vector<Eigen::Vector3d>& points, RandomStream& random);

class FloorPrior {
 public:
  /// Fits the floor to the landmarks below the camera, where gravity is not known. The first fit fixes the camera's
  /// height for good; later ones update the normal alone.
  void Update(const KeyframeMap& map, const Pose& X_WC, RandomStream& random);

  /// The same where gravity is known. The mean of the first five measurements, whose baseline is longer than that of
  /// the map's first two views, fixes the height. The normal is the measured one, or else the vertical.
  /// @param carried,measured lengths in the map's unit, directions and positions in W
  void Update(const KeyframeMap& map, const Pose& X_WC, const Carried& carried,
              const std::optional<CarriedHeight>& measured);

  /// Inverse depth of a feature if it lies on the floor. Nothing above or near the horizon, while no floor was found,
  /// or where three landmarks or more hide it: each stands on the floor and hides what lies behind it up to its own
  /// height. Landmarks that the measured floor is seen through hide nothing: they were matched wrongly.
  /// @param xy normalised image coordinates
  std::optional<DepthPrior> DepthAt(const Pose& X_WC, const Eigen::Vector2d& xy) const;

  /// Forgets the height: a new map has a new unit.
  void Clear() {
    height_.reset();
    measurements_ = 0;
    obstacles_.clear();
  }

  std::optional<double> height() const { return height_; }  ///< Of the camera over the floor, in the map's unit.
  const Eigen::Vector3d& normal() const { return normal_W_; }

 private:
  struct Standing {
    Eigen::Vector3d level;  ///< From the camera, along the floor.
    double height = 0;      ///< Over the floor.
  };
  Standing StandingAt(const Pose& X_WC, const Eigen::Vector3d& p_W) const;
  bool Hides(const Standing& obstacle, const Standing& floor_point) const;
  void FindObstacles(const KeyframeMap& map, const Pose& X_WC, double height,
                     const std::vector<Eigen::Vector3d>& seen_on_floor_W);
  bool IsOccluded(const Pose& X_WC, const Eigen::Vector3d& floor_point_W) const;

  std::optional<double> height_;
  double height_now_ = 0;  ///< The camera's height at the last update, in the map's unit, which drifts; 0: unknown.
  int measurements_ = 0;   ///< That `height_` is the mean of, where gravity is known.
  Eigen::Vector3d normal_W_ = Eigen::Vector3d::Zero();  ///< Up.
  std::vector<Eigen::Vector3d> obstacles_;              ///< Landmarks well above the floor, in W.
};

}  // namespace gaitcam
