/// How the camera moved while and between exposures: it turned by the gyroscope where there is one, and went as fast as
/// from one pose to the next, changed since by the accelerometer; without an IMU, as it last moved from frame to frame.
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
  /// The next pose does not go on from the others.
  void ForgetPoses();

  int64_t stamp_ns() const { return stamp_ns_; }  ///< Of the present frame.
  /// Whether the present frame's exposure was measured.
  bool HasGyro() const;
  bool HasPose() const { return !poses_.empty(); }
  /// Rotations over the present frame's exposure against its middle; none if it took no time or nothing is known.
  std::vector<ExposureRotation> Rotations() const;
  /// Where the camera was over the present frame's exposure, at equally spaced instants, as poses that map points of
  /// the camera at mid-exposure into the camera then. None where Rotations() has none.
  std::vector<Pose> Path() const;
  /// The same over the exposures of rows evenly spaced from the first to the last, each against the camera at that
  /// row's mid-exposure, if a shutter rolls for so long about the frame's stamp. Path() alone where the IMU did not
  /// measure it, or nothing rolls; none where Path() has none.
  std::vector<std::vector<Pose>> PathsOfRows(double readout_ms) const;
  /// Where the camera was when those rows were in the middle of their exposure, against the frame's stamp. None where
  /// the IMU did not measure it, or nothing rolls.
  std::vector<Pose> ReadoutPath(double readout_ms) const;
  /// Of what goes uniformly for so short a time, at mid-exposure, m/s in the camera's frame: of the IMU's origin, or of
  /// the camera where there is none; zero where nothing is known.
  Eigen::Vector3d Velocity() const;
  /// Of what Velocity() is, in the camera's frame, m.
  Eigen::Vector3d MovingPoint() const;
  /// From the present frame's camera into the last frame's that had a pose; the identity where nothing is known.
  Eigen::Quaterniond TurnSinceLastPose() const;
  /// Where the present frame's camera is: turned since the last pose, and, if that is less than 0.3 s old, moved.
  /// @pre a pose was added
  Pose PredictPose() const;
  /// Whether that was measured all the way.
  bool PredictsPosition() const { return HasGyro() && KnowsVelocity(); }
  /// How wrong the turn may be, one standard deviation about each axis, rad: by a gyroscope as a bench calibrates it
  /// (0.5 deg of misalignment, 2 ms of offset, 0.01 rad/s of bias), or, without one, as fast as a head turns.
  double TurnSigma() const;
  /// Covariance of the gyroscope's rate while a shutter rolls for so long, (rad/s)^2 in the camera's frame: by the same
  /// misalignment and offset. A bias, which shears all frames alike, is not in it. Zero where ReadoutPath() has none.
  Eigen::Matrix3d RateCovariance(double readout_ms) const;

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
  const ImuSample& ReadingAt(int64_t stamp_ns) const;
  /// What the IMU's origin did between two instants beside moving uniformly.
  struct Change {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), position = Eigen::Vector3d::Zero();
  };
  template <class Visit>
  void IntegrateForce(const StampedPose& from, int64_t to_ns, Visit visit) const;
  Change ChangeSince(const StampedPose& from, int64_t to_ns) const;
  void LearnVelocity(const StampedPose& before, const StampedPose& now);
  bool KnowsVelocity() const;
  std::vector<Pose> PathAt(const std::vector<ExposureRotation>& rotations, int64_t middle_ns) const;

  ImuCalibration imu_;
  bool use_imu_;
  std::vector<ImuSample> readings_;  ///< Those that the present frame and the time since the last one need.
  int64_t stamp_ns_ = 0, open_ns_ = 0, close_ns_ = 0;
  std::vector<StampedPose> poses_;  ///< The latest, at most three.
  /// Of what Path() takes to move uniformly, at the latest pose: the IMU's origin, or the camera's; m/s in the world.
  Eigen::Vector3d velocity_W_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_W_ = Eigen::Vector3d::Zero();  ///< Mean specific force so far: gravity's, upwards.
  double force_s_ = 0;                                 ///< Over so much time.
  double acceleration2_ = 0;                           ///< Mean square of a coordinate, (m/s^2)^2 ...
  double turn_acceleration2_ = 0;                      ///< ... and (rad/s^2)^2, over the latest frames.
};

}  // namespace gaitcam
