/// How the camera turned while and between exposures: by the gyroscope where there is one, else as it last turned from
/// frame to frame.
///
/// A key point of a blurred image lies where its point was on average over the exposure, not where it was in the
/// middle, which is what the frame's stamp means. The difference is a rotation, the mean over the exposure, and of
/// second order in its length.

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
  /// To be told of every pose that was found (of the mean over the exposure).
  void AddPose(int64_t stamp_ns, const Pose& X_WC);

  /// Whether the present frame's exposure was measured.
  bool HasGyro() const { return use_imu_ && !readings_.empty(); }
  /// Rotations over the present frame's exposure against its middle; none if it took no time or nothing is known.
  std::vector<ExposureRotation> Rotations() const;
  /// From the present frame's camera into the last frame's that had a pose; the identity where nothing is known.
  Eigen::Quaterniond TurnSinceLastPose() const;

  /// The camera at mid-exposure against the mean of the exposure: maps points of the former into the latter.
  Eigen::Quaterniond MeanFromMiddle() const;
  /// Covariance of a pose at mid-exposure that comes from the part of the motion during the exposure that is not known:
  /// of the accelerations that the latest poses show, and of a tenth of the turn that MeanFromMiddle makes good.
  Matrix6d UnknownMotion() const;

 private:
  ImuCalibration imu_;
  bool use_imu_;
  std::vector<ImuSample> readings_;  ///< Those that the present frame and the time since the last one need.
  int64_t stamp_ns_ = 0, open_ns_ = 0, close_ns_ = 0;
  std::vector<StampedPose> poses_;  ///< The latest, at most three.
  double acceleration2_ = 0;        ///< Mean square of a coordinate, (m/s^2)^2 ...
  double turn_acceleration2_ = 0;   ///< ... and (rad/s^2)^2, over the latest frames.
};

}  // namespace gaitcam
