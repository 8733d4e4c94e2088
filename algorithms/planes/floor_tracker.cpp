#include "algorithms/planes/floor_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/shutter_turn.h"
#include "algorithms/planes/alignment_image.h"

namespace gaitcam {

FloorTracker::FloorTracker(const Calibration& calibration, const FloorTrackerOptions& options)
    : calibration_(calibration),
      options_(options),
      undistortion_(calibration.camera),
      aligner_(undistortion_.camera(), options.alignment),
      motion_(calibration.imu, options.use_imu) {
  CheckFields(options, "floor_tracker.");
  if (!calibration.standing) {
    throw BadInput("the calibration does not say how high the camera stands (standing: height_m, up_C)");
  }
  if (options.use_imu && calibration.imu.rate_hz > 0) gyro_.emplace(calibration.imu);
}

FloorTrack FloorTracker::Track(const Observation& observation) {
  const Turn turn = Integrate(observation);
  FollowGravity(observation, turn);
  motion_.Add(observation);
  grey_ = undistortion_.Grey(observation.image.pixels, RollingShutter(observation));
  image_ = aligner_.MakePyramid(AlignmentImage(grey_));
  FloorTrack track;
  cv::Mat rejected;
  const FloorTrackerState before = state_;
  const Event event = keyframe_ ? Follow(observation, turn, track, rejected) : Initialize(observation, track);
  state_ = NextState(before, event);
  if (event == Event::kLost || event == Event::kNotFloor) {
    if (event == Event::kLost && ShowsFloor(before) && keyframe_->aligned_frames > 0) {
      track.retired = keyframe_->Retired();
    }
    Restart(observation, rejected, track);
    motion_.ForgetPoses();
  } else if (event != Event::kMissed) {
    track.tracked = state_ == FloorTrackerState::kTracking;
    track.restarted = before == FloorTrackerState::kRestarted;
    X_last_ = tracked_ns_ > 0 ? X_WC_.Inverse() * track.X_WC : Pose();
    if (track.tracked) {
      tracked_ns_ = observation.stamp_ns;
      X_WC_dead_ = track.X_WC;
    }
  }
  if (event != Event::kMissed) motion_.AddPose(observation.stamp_ns, track.X_WC);
  X_WC_ = track.X_WC;
  last_ns_ = observation.stamp_ns;
  return track;
}

std::optional<FloorKeyframe> FloorTracker::Finish() const {
  if (!ShowsFloor(state_) || (keyframe_->aligned_frames == 0 && keyframe_->stamp_ns != last_ns_)) return std::nullopt;
  return keyframe_->Retired();
}

FloorTracker::Turn FloorTracker::Integrate(const Observation& observation) {
  if (!gyro_) return {};
  gyro_->Add(observation.imu);
  const int64_t now_ns = observation.stamp_ns, half_exposure_ns = std::llround(0.5e6 * observation.exposure_ms);
  Turn turn;
  if (last_ns_ > 0) turn.since_last = gyro_->Between(last_ns_, now_ns);
  if (half_exposure_ns > 0) {
    turn.during_exposure = gyro_->Between(now_ns - half_exposure_ns, now_ns + half_exposure_ns);
  }
  constexpr int64_t kKeep_ns = 300'000'000;
  gyro_->DropBefore(observation.stamp_ns - kKeep_ns);
  return turn;
}

/// A turn that the gyroscope did not measure leaves the vertical unknown, until it measures again: then images have it.
void FloorTracker::FollowGravity(const Observation& observation, const Turn& turn) {
  const bool is_first = last_ns_ == 0;
  if (!is_first && !turn.since_last) gravity_.reset();
  if (!gyro_ || observation.imu.empty() || !(is_first || turn.since_last)) return;
  if (!gravity_) {
    const bool has_pose = !is_first && tracked_ns_ == last_ns_;
    gravity_.emplace(calibration_.imu,
                     has_pose ? X_WC_.rotation.conjugate() * Eigen::Vector3d::UnitZ() : calibration_.standing->up_C);
  }
  gravity_->Add(observation.imu, gyro_->bias());
}

/// Empty where the shutter does not roll, or the gyroscope did not measure it.
SeenAtRow FloorTracker::RollingShutter(const Observation& observation) const {
  if (!options_.shutter_by_imu || !gyro_ || !(calibration_.readout_ms > 0)) return {};
  const auto shutter = ShutterTurn::Measure(*gyro_, observation.stamp_ns, calibration_.readout_ms);
  if (!shutter) return {};
  Eigen::Vector3d normal_d = Eigen::Vector3d::Zero();  // of the floor, 1/m; zero: it is infinitely far
  if (motion_.HasPose()) normal_d = FloorPlaneState(motion_.PredictPose()).normal_d;
  const Eigen::Vector3d moved = 1e-3 * calibration_.readout_ms * motion_.Velocity(), p = motion_.MovingPoint();
  return [turn = *shutter, normal_d, moved, p](const Eigen::Vector3d& ray_S, double row) -> Eigen::Vector3d {
    const Eigen::Quaterniond R_ST = turn.R_ST(row);
    const Eigen::Vector3d p_ST = (row - 0.5) * moved + p - R_ST * p;
    const double inverse_depth = std::max(0.0, normal_d.dot(ray_S));
    return R_ST.conjugate() * (ray_S - inverse_depth * p_ST);
  };
}

/// By the accelerometer, or as the camera stands where that says nothing.
const Eigen::Vector3d& FloorTracker::UpC() const { return gravity_ ? gravity_->up_C() : calibration_.standing->up_C; }

FloorTrackerEvent FloorTracker::Initialize(const Observation& observation, FloorTrack& track) {
  Pose level;  // looking along x: camera z to world x, camera x to world -y
  level.rotation = Eigen::Quaterniond((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  track.X_WC = Upright(level, UpC(), calibration_.standing->height_m);
  track.X_WC = BelowCamera(track.X_WC).Inverse().Lifted() * track.X_WC;
  X_WC_ = track.X_WC;
  MakeKeyframe(observation.stamp_ns, track.X_WC, BlurMotion::Zero(), {});
  track.keyframe = keyframe_->id;
  track.points = track.inliers = int(keyframe_->pixels.points.front().size());
  if (track.points >= options_.min_points) return Event::kAligned;
  keyframe_.reset();
  return Event::kMissed;
}

FloorTrackerEvent FloorTracker::Follow(const Observation& observation, const Turn& turn, FloorTrack& track,
                                       cv::Mat& rejected) {
  TurnOn(observation, turn);
  const Attempt attempt = Align(observation, turn);
  const FloorTrack candidate = Described(attempt);
  if (!IsPlausible(attempt, candidate)) {
    track.points = candidate.points;
    track.inliers = candidate.inliers;
    track.X_WC = attempt.predicted;
    const bool lost = state_ == FloorTrackerState::kRestarted || ++keyframe_->missed_frames > options_.max_lost_frames;
    return lost ? Event::kLost : Event::kMissed;
  }
  track = candidate;
  track.keyframe = keyframe_->id;
  track.tentative = !ShowsFloor(state_);
  ++keyframe_->aligned_frames;
  keyframe_->missed_frames = 0;
  return IsDue(track, attempt.alignment.inside_ratio) ? Succeed(observation, attempt, track, rejected)
                                                      : Event::kAligned;
}

/// The rotation since the keyframe, and that since the frame tracked last, as the gyroscope has them.
void FloorTracker::TurnOn(const Observation& observation, const Turn& turn) {
  if (!turn.since_last) {
    keyframe_->R_KC_gyro.reset();
    return;
  }
  X_WC_dead_.rotation = X_WC_dead_.rotation * ExpSo3(*turn.since_last);
  if (keyframe_->R_KC_gyro) *keyframe_->R_KC_gyro = *keyframe_->R_KC_gyro * ExpSo3(*turn.since_last);
  keyframe_->gyro_s += double(observation.stamp_ns - last_ns_) * 1e-9;
}

/// From the pose predicted by constant velocity, its rotation by the gyroscope.
FloorTracker::Attempt FloorTracker::Align(const Observation& observation, const Turn& turn) const {
  const double dt = double(observation.stamp_ns - last_ns_) * 1e-9;
  Attempt attempt;
  attempt.predicted = X_WC_ * X_last_;
  if (turn.since_last) attempt.predicted.rotation = X_WC_.rotation * ExpSo3(*turn.since_last);
  PlaneState guess = keyframe_->plane;
  guess.X_CR = attempt.predicted.Inverse() * keyframe_->X_WK;
  PlanePrior prior;
  prior.distance_sigma = 0.1 * options_.height_sigma_ratio;
  prior.tilt_sigma_rad = options_.tilt_sigma_deg * kRadPerDeg;
  prior.rotation_sigma_rad = (turn.since_last ? 2 : 10) * kRadPerDeg;
  prior.translation_sigma_m = 0.3 * calibration_.standing->height_m;
  attempt.blur.ratio = observation.exposure_ms * 1e-3 / dt;
  attempt.blur.X_RP = keyframe_->X_WK.Inverse() * X_WC_;
  attempt.blur.turn = turn.during_exposure;
  attempt.alignment = aligner_.Align(keyframe_->pixels, image_, guess, prior, attempt.blur);
  return attempt;
}

/// What the alignment says of the frame, whether plausible or not.
FloorTrack FloorTracker::Described(const Attempt& attempt) const {
  const PlaneState& state = attempt.alignment.state;
  const Eigen::Vector3d n_d = state.normal_d;
  const Pose X_WK = Upright(keyframe_->X_WK, -n_d.normalized(), 1 / n_d.norm());
  FloorTrack track;
  track.points = int(keyframe_->pixels.points.front().size());
  track.inliers = attempt.alignment.inliers;
  track.X_WC = X_WK * state.X_CR.Inverse();
  track.covariance = PlanarCovariance(track.X_WC, CovarianceOfInverse(state.X_CR, attempt.alignment.motion_covariance));
  const BlurMotion motion = attempt.blur.Motion(state.X_CR);
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() / std::max(0.1 * n_d.norm(), (state.X_CR.R() * n_d).z());
  track.blur_px = camera().fx / ahead.z() * (motion.head<3>() + motion.tail<3>().cross(ahead)).head<2>().norm();
  return track;
}

/// A camera that takes something else for the floor soon leans, rises or sinks, or rotates without the gyroscope.
bool FloorTracker::IsPlausible(const Attempt& attempt, const FloorTrack& track) const {
  const PlaneAlignment& found = attempt.alignment;
  if (!found.converged || !(found.correlation >= options_.min_correlation) || track.points < options_.min_points) {
    return false;
  }
  const Eigen::Vector3d up_C = track.X_WC.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(up_C.dot(UpC()), -1.0, 1.0));
  if (!(tilt < options_.max_tilt_deg * kRadPerDeg)) return false;
  const double height_ratio = track.X_WC.translation.z() / calibration_.standing->height_m;
  if (!(std::abs(height_ratio - 1) < options_.max_height_ratio)) return false;
  if (!keyframe_->R_KC_gyro) return true;
  const double max_turn = options_.max_turn_deg * kRadPerDeg + 3 * gyro_->bias_sigma() * keyframe_->gyro_s;
  return RotationAngle(found.state.X_CR.rotation.conjugate(), *keyframe_->R_KC_gyro) < max_turn;
}

bool FloorTracker::IsDue(const FloorTrack& track, double inside_ratio) const {
  const double moved_m = (track.X_WC.translation - keyframe_->X_WK.translation).norm();
  return moved_m > options_.keyframe_move_heights * calibration_.standing->height_m ||
         RotationAngle(track.X_WC.rotation, keyframe_->X_WK.rotation) > options_.keyframe_turn_deg * kRadPerDeg ||
         inside_ratio < options_.keyframe_inside_ratio;
}

/// The frame becomes the next keyframe, if the regions of the last one prove to be floor.
FloorTrackerEvent FloorTracker::Succeed(const Observation& observation, const Attempt& attempt, FloorTrack& track,
                                        cv::Mat& rejected) {
  const PlaneState& now = attempt.alignment.state;
  FloorKeyframe retired = Retire(*keyframe_, aligner_, camera(), image_, now, attempt.blur, options_.regions);
  rejected = WarpRejected(retired, camera(), now);
  if (retired.FloorRatio() < options_.min_floor_ratio) {
    track.tentative = false;
    return Event::kNotFloor;
  }
  if (keyframe_->R_KC_gyro) {
    constexpr double kMinTime_s = 1e-3, kTurnSigma_rad = 0.15 * kRadPerDeg;  // of a keyframe's alignment
    gyro_->LearnBias(LogSo3(now.X_CR.rotation * *keyframe_->R_KC_gyro), std::max(keyframe_->gyro_s, kMinTime_s),
                     kTurnSigma_rad);
  }
  track.retired = std::move(retired);
  track.X_WC = Corrected(track.X_WC);
  MakeKeyframe(observation.stamp_ns, track.X_WC, attempt.blur.Motion(now.X_CR), rejected);
  keyframe_->covariance = track.covariance;
  return Event::kSucceeded;
}

/// The camera is carried about as high as it stands, and gravity is down: each keyframe corrects a part of the drift.
Pose FloorTracker::Corrected(const Pose& X_WC) const {
  const double height = X_WC.translation.z();
  const double better = height + options_.height_gain * (calibration_.standing->height_m - height);
  Eigen::Vector3d up_C = X_WC.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  if (gravity_) up_C = (up_C + options_.tilt_gain * (gravity_->up_C() - up_C)).normalized();
  return Upright(X_WC, up_C, better);
}

/// After a loss: a new keyframe at dead reckoning's pose. Whether it shows floor, the next frames tell.
void FloorTracker::Restart(const Observation& observation, const cv::Mat& rejected, FloorTrack& track) {
  constexpr double kSpeed_m_s = 0.3, kTurn_rad_s = 0.5, kGyroTurn_rad_s = 0.02;
  const double gone_s = double(observation.stamp_ns - tracked_ns_) * 1e-9;
  const double turn_rad_s = gyro_ && gyro_->has_samples() ? kGyroTurn_rad_s : kTurn_rad_s;
  track.X_WC = Upright(X_WC_dead_, UpC(), calibration_.standing->height_m);
  MakeKeyframe(observation.stamp_ns, track.X_WC, BlurMotion::Zero(), rejected);
  const Eigen::Vector3d sigma = gone_s * Eigen::Vector3d(kSpeed_m_s, kSpeed_m_s, turn_rad_s);
  keyframe_->covariance = sigma.cwiseAbs2().asDiagonal();
  X_last_ = Pose();
}

/// @param rejected where the image is known to show something other than floor; may be empty.
void FloorTracker::MakeKeyframe(int64_t stamp_ns, const Pose& X_WC, const BlurMotion& blur, const cv::Mat& rejected) {
  FloorReference keyframe;
  keyframe.mask = FloorMask(camera(), X_WC, options_.range_heights);
  if (!rejected.empty()) keyframe.mask.setTo(0, rejected);
  keyframe.grey = grey_;
  keyframe.pixels = aligner_.MakeReference(AlignmentImage(grey_), keyframe.mask);
  keyframe.pixels.blur = blur;
  keyframe.regions = FindPutativePlanes(grey_, options_.regions.putative);
  keyframe.plane = FloorPlaneState(X_WC);
  keyframe.X_WK = X_WC;
  keyframe.stamp_ns = stamp_ns;
  keyframe.id = keyframes_++;
  keyframe_ = std::move(keyframe);
}

}  // namespace gaitcam
