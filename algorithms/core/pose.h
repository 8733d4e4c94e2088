/// Rigid motions. `X_WC` maps points of frame C into frame W: p_W = X_WC * p_C.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace gaitcam {

/// A rigid motion: rotation (unit Hamilton quaternion), then translation in metres.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Pose() = default;
  Pose(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : rotation(q.normalized()), translation(t) {}
  Pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t)
      : rotation(Eigen::Quaterniond(R).normalized()), translation(t) {}

  Pose Inverse() const;
  Eigen::Matrix3d R() const { return rotation.toRotationMatrix(); }
  Eigen::Matrix4d Matrix() const;
  /// Rotation about the world's z axis (up), rad in (-pi, pi].
  double Yaw() const;
};

Pose operator*(const Pose& X_AB, const Pose& X_BC);
Eigen::Vector3d operator*(const Pose& X_AB, const Eigen::Vector3d& p_B);

/// A pose at an instant. Stamps are nanoseconds on the run's one clock.
struct StampedPose {
  int64_t stamp_ns = 0;
  Pose pose;
};

/// Linear in translation, spherical-linear in rotation; `s` in [0, 1].
Pose Interpolate(const Pose& a, const Pose& b, double s);

/// Angle of the rotation that leads from a to b, rad in [0, pi].
double RotationAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// @returns `angle` plus a multiple of 2 pi, in (-pi, pi].
double WrapAngle(double angle);

/// Rotations about one axis by `angle` rad.
Eigen::Matrix3d RotX(double angle);
Eigen::Matrix3d RotY(double angle);
Eigen::Matrix3d RotZ(double angle);

}  // namespace gaitcam
