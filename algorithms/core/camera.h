/// The pinhole camera with radial-tangential (Brown-Conrady) lens distortion, as in OpenCV.
///
/// Camera frame: x right, y down, z forward along the optical axis. A point (X, Y, Z) with Z > 0 projects to
///   x = X/Z, y = Y/Z, r2 = x^2 + y^2
///   x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)
///   y' = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 y^2) + 2 p2 x y
///   u = fx x' + cx, v = fy y' + cy,    the centre of the first pixel being (0, 0).

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "algorithms/core/pose.h"

namespace gaitcam {

struct CameraModel {
  int width_px = 0;
  int height_px = 0;
  double fx = 0, fy = 0;                          ///< Focal lengths, px.
  double cx = 0, cy = 0;                          ///< Principal point, px from the centre of the first pixel.
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;  ///< Distortion; all zero is an ideal pinhole.

  /// An ideal pinhole with square pixels whose image spans `hfov_deg` from edge to edge.
  static CameraModel FromHorizontalFov(int width_px, int height_px, double hfov_deg);

  bool IsDistorted() const;
  /// @returns pixel coordinates of a point in the camera frame, or nothing if it lies behind the camera (Z <= 0).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_C) const;
  /// @returns the point (x, y, 1) on the ray through a pixel; distortion is undone to 1e-12 by Newton's method.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const;
  /// Distorted normalised coordinates of ideal ones.
  Eigen::Vector2d Distort(const Eigen::Vector2d& ideal) const;
  /// Its derivative by the ideal coordinates.
  Eigen::Matrix2d DistortionJacobian(const Eigen::Vector2d& ideal) const;
  bool Contains(const Eigen::Vector2d& pixel) const;
  Eigen::Matrix3d K() const;

  /// @throws BadOption if the size or a focal length is not positive.
  void Check() const;
};

/// IMU noise as data sheets state it; continuous-time densities and random walks.
struct ImuCalibration {
  double rate_hz = 0;              ///< 0: there is no IMU.
  double gyro_noise_density = 0;   ///< rad/s/sqrt(Hz)
  double gyro_random_walk = 0;     ///< rad/s^2/sqrt(Hz)
  double accel_noise_density = 0;  ///< m/s^2/sqrt(Hz)
  double accel_random_walk = 0;    ///< m/s^3/sqrt(Hz)
  Pose X_CI;                       ///< Maps points of the IMU frame into the (left) camera frame, neck at rest.
};

/// How the camera is carried while the robot stands on flat ground, ready to walk: its kinematics say so.
struct StandingCamera {
  double height_m = 0;                               ///< Of the camera's centre over the soles.
  Eigen::Vector3d up_C = -Eigen::Vector3d::UnitY();  ///< The floor's upward normal, in the (left) camera's frame.
  double height_sigma = 0;  ///< How wrong the height may be, one standard deviation, a part of it; 0: exact.
  double pitch_sigma = 0;   ///< Likewise of the camera's pitch in up_C, rad.
};

/// How wrong a calibration of lenses may be, as the bench that made it says: standard deviations of errors that are the
/// same in all images. Zero: exact.
struct LensUncertainty {
  double focal = 0;        ///< Of the focal length, a part of it; of a rig, of both alike.
  double centre_px = 0;    ///< Of each coordinate of the principal point, likewise.
  double right_focal = 0;  ///< Of the right focal length beside what both are off alike.

  bool IsExact() const { return focal == 0 && centre_px == 0 && right_focal == 0; }
};

/// The depth camera, whose pixels are those of the left image. All zero: exact.
struct DepthCalibration {
  double sigma_m = 0;      ///< Standard deviation of a depth at any distance, m ...
  double sigma_per_m = 0;  ///< ... and of one that grows with the distance's square, m at 1 m.

  double Sigma(double depth_m) const { return std::hypot(sigma_m, sigma_per_m * depth_m * depth_m); }
};

/// The body's odometry. The body's frame B has its origin on the floor below the trunk, x forward, z up. Errors are a
/// random walk: their variances grow in proportion to the way.
struct OdometryCalibration {
  double rate_hz = 0;               ///< 0: the body has none.
  Pose X_BC;                        ///< Maps points of the (left) camera frame into B, the robot standing.
  double position_per_sqrt_m = 0;   ///< Standard deviation of the position after 1 m, each of x and y; m.
  double heading_per_sqrt_m = 0;    ///< Of the heading after 1 m; rad.
  double heading_per_sqrt_rad = 0;  ///< Of the heading after a turn of 1 rad; rad.
  double rocking_m = 0.003;         ///< Of the height of the body, and of the camera on it, about that of X_BC; m.
  double rocking_rad = 0.005;       ///< Likewise of its tilt, about either level axis; rad.
};

/// What a SLAM system is told about the sensors: everything that a calibration would yield, and nothing more.
struct Calibration {
  CameraModel camera;                ///< Left, or the only one.
  std::optional<CameraModel> right;  ///< Present for a stereo rig.
  Pose X_LR;                         ///< Maps points of the right camera into the left one.
  LensUncertainty lens;
  bool has_depth = false;
  DepthCalibration depth;
  OdometryCalibration odometry;
  double frame_rate_hz = 0;
  double readout_ms = 0;  ///< Rolling shutter: from the first row's exposure to the last row's; 0: global shutter.
  ImuCalibration imu;
  std::optional<StandingCamera> standing;  ///< Absent where it was not measured.
};

}  // namespace gaitcam
