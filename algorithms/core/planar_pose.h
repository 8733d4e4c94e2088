/// Poses on the floor, the plane z = 0: where something stands and which way it faces.

#pragma once

#include <Eigen/Core>

#include "algorithms/core/se3.h"

namespace gaitcam {

/// A pose on the floor: position in m and heading in rad (not wrapped: a full circle ends at 2 pi).
struct PlanarPose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading = 0;

  PlanarPose() = default;
  PlanarPose(const Eigen::Vector2d& p, double h) : position(p), heading(h) {}
  /// Drops height, roll and pitch.
  explicit PlanarPose(const Pose& pose) : position(pose.translation.head<2>()), heading(pose.Yaw()) {}

  PlanarPose Inverse() const;
  /// The rigid motion as a 3D pose at height `z`.
  Pose Lifted(double z = 0) const;
};

PlanarPose operator*(const PlanarPose& X_AB, const PlanarPose& X_BC);
Eigen::Vector2d operator*(const PlanarPose& X_AB, const Eigen::Vector2d& p_B);

/// `v` turned to the left by `angle` rad.
Eigen::Vector2d Rotate(const Eigen::Vector2d& v, double angle);

/// A pose on the floor that moves many points: its sine and cosine are computed once.
class PlanarMotion {
 public:
  explicit PlanarMotion(const PlanarPose& X_AB);

  /// X_AB * p_B, to the bit.
  Eigen::Vector2d operator*(const Eigen::Vector2d& p_B) const {
    return position_ + Eigen::Vector2d(c_ * p_B.x() - s_ * p_B.y(), s_ * p_B.x() + c_ * p_B.y());
  }

 private:
  Eigen::Vector2d position_;
  double c_, s_;
};

/// The frame on the floor below a camera (x right, y down, z forward): x along its view. What remains of X_WC after it
/// is height and tilt alone.
/// @pre the camera does not look straight up or down.
PlanarPose BelowCamera(const Pose& X_WC);

/// Ad of a planar motion: X_AB Exp(tau) = Exp(Ad tau) X_AB for tau = (x, y, yaw), as se3.h has it in space.
Eigen::Matrix3d PlanarAdjoint(const PlanarPose& X_AB);

/// The part of a camera pose's uncertainty that lies in the floor.
/// @param covariance of X_WC, in the tangent of se3.h.
/// @returns that of the position's x and y (m) and of the rotation about the vertical (rad), in the frame below the
/// camera.
Eigen::Matrix3d PlanarCovariance(const Pose& X_WC, const Matrix6d& covariance);

/// The other way round: of a camera pose, given that part and how well height and tilt are known.
/// @param height_sigma m. @param tilt_sigma rad, of a rotation about each horizontal axis.
/// @returns that of X_WC, in the tangent of se3.h.
Matrix6d SpatialCovariance(const Pose& X_WC, const Eigen::Matrix3d& planar, double height_sigma, double tilt_sigma);

}  // namespace gaitcam
