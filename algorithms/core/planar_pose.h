/// Motions within the plane z = 0: where something stands and which way it faces.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "algorithms/core/pose.h"

namespace gaitcam {

struct PlanarPose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
  double yaw = 0;                                      ///< rad, any multiple of 2 pi added.

  PlanarPose operator*(const PlanarPose& next) const {
    return {position + Eigen::Rotation2Dd(yaw) * next.position, yaw + next.yaw};
  }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return position + Eigen::Rotation2Dd(yaw) * p; }
  PlanarPose Inverse() const { return {-(Eigen::Rotation2Dd(-yaw) * position), -yaw}; }
  Pose ToPose() const {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {position.x(), position.y(), 0}};
  }
};

/// The frame on the floor below a camera (x right, y down, z forward): x along its view. What remains of X_WC after it
/// is height and tilt alone.
/// @pre the camera does not look straight up or down.
inline PlanarPose BelowCamera(const Pose& X_WC) {
  const Eigen::Vector3d forward = X_WC.rotation * Eigen::Vector3d::UnitZ();
  return {X_WC.translation.head<2>(), std::atan2(forward.y(), forward.x())};
}

}  // namespace gaitcam
