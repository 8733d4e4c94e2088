/// What a SLAM system may see. There is no pose in it, ever: truth lives on the simulator's side.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/image.h"

namespace gaitcam {

/// One reading of an inertial measurement unit, in the IMU's own frame.
struct ImuSample {
  int64_t stamp_ns = 0;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();    ///< rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s^2; at rest it points up, against gravity.
};

/// One reading of all joint encoders and foot switches.
struct JointSample {
  int64_t stamp_ns = 0;
  std::vector<double> position;  ///< rad (m for sliding joints), in the order of the robot's joints.
  bool left_contact = false;     ///< The left foot's switch is closed.
  bool right_contact = false;
};

/// One reading of the body's own odometry: how its wheels or legs say that it has moved over the floor.
struct OdometrySample {
  int64_t stamp_ns = 0;
  /// Of the body (OdometryCalibration, camera.h) in O, the frame where it stood at the start. Their errors add up.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
  double heading = 0;                                  ///< rad, left positive, not wrapped.
};

/// Where the camera of a robot looks that stands and turns it to see all around, by the robot's own joints and steps.
struct ScanState {
  double pan_rad = 0;        ///< Camera against the trunk about the vertical, at mid-exposure; left is positive.
  double body_turn_rad = 0;  ///< How far the robot believes to have turned on the spot since the scan began.
};

/// One frame and everything sensed since the frame before it.
struct Observation {
  int64_t stamp_ns = 0;             ///< Middle of the exposure.
  double exposure_ms = 0;           ///< Shutter open to close.
  Image image;                      ///< Left camera, or the only one: CV_8UC1 or CV_8UC3 (BGR).
  std::optional<Image> right;       ///< Stereo rigs only.
  std::optional<Image> depth;       ///< RGB-D rigs only, CV_32FC1, metres.
  std::vector<ImuSample> imu;       ///< In time order, after the previous frame's last, up to this shutter's close.
  std::vector<JointSample> joints;  ///< Likewise. Empty when read from a dataset that has none.
  std::vector<OdometrySample> odometry;  ///< Likewise, of the body. Empty where it has none.
  std::optional<ScanState>
      scan;  ///< Set while the robot stands and scans, as the system asked (a Scan, body_command.h).
};

}  // namespace gaitcam
