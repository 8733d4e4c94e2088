/// How the camera turned while and between exposures: by the gyroscope where there is one, else as it last turned from
/// frame to frame.
///
/// A key point of a blurred image does not lie where its point was at mid-exposure, which is what the frame's stamp
/// means: see BlurOffset (keypoint_noise.h).

#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/se3.h"
#include "algorithms/features/psf_inertial.h"

namespace gaitcam {

class ExposureMotion {
 public:
  /// @param use_imu false: as if there were none
  ExposureMotion(const ImuCalibration& imu, bool use_imu) : imu_(imu), use_imu_(use_imu && imu.rate_hz > 0) {}

  /// To be told of every frame, before it is asked about.
  void Add(const Observation& observation);
  /// To be told of every pose that was found.
  void AddPose(int64_t stamp_ns, const Pose& X_WC);

  int64_t stamp_ns() const { return stamp_ns_; }  ///< Of the present frame.
  /// Whether the present frame's exposure was measured.
  bool HasGyro() const;
  /// Rotations over the present frame's exposure against its middle; none if it took no time or nothing is known.
  std::vector<ExposureRotation> Rotations() const;
  /// From the present frame's camera into the last frame's that had a pose; the identity where nothing is known.
  Eigen::Quaterniond TurnSinceLastPose() const;
  /// How wrong that may be, one standard deviation about each axis, rad: by a gyroscope as a bench calibrates it (0.5
  /// deg of misalignment, 2 ms of offset, 0.01 rad/s of bias), or, without one, as fast as a head turns.
  double TurnSigma() const;

  /// Covariance over the exposure of the turn against its middle, rad^2. Of a uniform turn by a it is a^2 / 12.
  Eigen::Matrix3d TurnSpread() const;
  /// The length of a uniform turn of this spread, rad.
  double Extent() const;
  /// Covariance of a pose at mid-exposure that comes from the part of the motion during the exposure that is not known:
  /// of the accelerations that the latest poses show, and a part of the turn over the exposure: where in a smeared
  /// image a detector sees its key points, it sees them alike all over the image.
  /// @param part of the turn's extent, one standard deviation
  Matrix6d UnknownMotion(double part) const;

 private:
  const Eigen::Vector3d& RateAt(int64_t stamp_ns) const;

  ImuCalibration imu_;
  bool use_imu_;
  std::vector<ImuSample> readings_;  ///< Those that the present frame and the time since the last one need.
  int64_t stamp_ns_ = 0, open_ns_ = 0, close_ns_ = 0;
  std::vector<StampedPose> poses_;  ///< The latest, at most three.
  double acceleration2_ = 0;        ///< Mean square of a coordinate, (m/s^2)^2 ...
  double turn_acceleration2_ = 0;   ///< ... and (rad/s^2)^2, over the latest frames.
};

}  // namespace gaitcam
