#include "algorithms/slam/floor_slam.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

FloorFilterOptions FilterOf(const FloorSlamOptions& options) {
  FloorFilterOptions filter = options.filter;
  if (options.use_map) return filter;
  filter.particles = 1;
  filter.inflation = filter.drift_ratio = filter.drift_deg_per_m = 0;
  filter.loop_m = 1e6;  // no loop closures
  return filter;
}

/// Of X_AC, in its own frame, by that of X_AB and of the motion X_BC.
Eigen::Matrix3d Compose(const Eigen::Matrix3d& X_AB, const PlanarPose& X_BC, const Eigen::Matrix3d& motion) {
  const Eigen::Matrix3d J = PlanarAdjoint(X_BC.Inverse());
  return J * X_AB * J.transpose() + motion;
}

}  // namespace

FloorSlam::FloorSlam(const Calibration& calibration, const FloorSlamOptions& options, uint64_t seed)
    : options_(options), tracker_(calibration, options.tracker), filter_(FilterOf(options), seed) {
  const StandingCamera standing = calibration.standing.value_or(StandingCamera());
  options_.height_sigma_ratio = std::hypot(options.height_sigma_ratio, standing.height_sigma);
  options_.tilt_sigma_deg = std::hypot(options.tilt_sigma_deg, standing.pitch_sigma / kRadPerDeg);
}

void FloorSlam::AddKeyframe(const FloorKeyframe& keyframe) {
  const PlanarPose here = BelowCamera(keyframe.X_WK);
  const PlanarPose motion = (keyframes_.empty() ? PlanarPose() : keyframes_.back()).Inverse() * here;
  const double range_m = options_.filter.range_heights * keyframe.X_WK.translation.z();
  filter_.Step(motion, keyframe.covariance,
               FloorPatch::Of(keyframe.image, keyframe.floor, tracker_.camera(), keyframe.X_WK, options_.filter.cell_m,
                              range_m, options_.filter.match_points));
  keyframes_.push_back(here);
  keyframe_of_id_[keyframe.id] = keyframe_ns_.size();
  keyframe_ns_.push_back(keyframe.stamp_ns);
}

/// A covariance in the frame below the camera, with what is known of scale, height and tilt.
Matrix6d FloorSlam::Spatial(const Pose& X_WC, const Eigen::Matrix3d& planar, double since_loss_s) const {
  constexpr double kLeastSigma = 2e-4;  // m and rad: of any image's alignment
  // After a loss the accelerometer alone says what is up, amid the jerks of steps; the floor takes some seconds to
  // tell.
  constexpr double kLostTilt_deg = 0.8, kSettled_s = 5;
  const PlanarPose below = BelowCamera(X_WC);
  const double ratio = options_.height_sigma_ratio;
  Eigen::Matrix3d sum = planar + std::pow(kLeastSigma, 2) * Eigen::Matrix3d::Identity();
  const Eigen::Vector2d from_start = ratio * Rotate(below.position, -below.heading);
  sum.topLeftCorner<2, 2>() += from_start * from_start.transpose();
  const double tilt_deg = std::hypot(options_.tilt_sigma_deg, kLostTilt_deg * std::exp(-since_loss_s / kSettled_s));
  return SpatialCovariance(X_WC, sum, ratio * X_WC.translation.z(), tilt_deg * kRadPerDeg);
}

/// The last retired keyframe's by the particles, then the motion to the present one, then that to this frame.
std::optional<Matrix6d> FloorSlam::LiveCovariance(const FloorTrack& track, const Pose& X_WC,
                                                  double since_loss_s) const {
  if (!options_.use_map) return std::nullopt;
  const PlanarPose here = BelowCamera(track.X_WC), start = keyframes_.empty() ? PlanarPose() : keyframes_.back();
  const Eigen::Matrix3d moved =
      track.retired ? track.covariance : Compose(present_covariance_, present_.Inverse() * here, track.covariance);
  const PlanarPose motion = start.Inverse() * here;
  Eigen::Matrix3d mapped = Eigen::Matrix3d::Zero();
  if (!keyframes_.empty()) {
    const Eigen::Matrix3d to_own = RotZ(-filter_.Mean().heading);
    mapped = to_own * filter_.Covariance() * to_own.transpose();
  }
  return Spatial(X_WC, Compose(mapped, motion, filter_.MotionCovariance(motion.position.norm(), moved)), since_loss_s);
}

FrameEstimate FloorSlam::Track(const Observation& observation) {
  const FloorTrack track = tracker_.Track(observation);
  Record record;
  record.X_tracked = track.X_WC;
  record.aligned = track.tracked || track.tentative;
  record.keyframe = track.keyframe;
  record.since_keyframe = track.covariance;
  if (track.restarted) found_again_ns_ = observation.stamp_ns;
  record.since_loss_s = found_again_ns_ ? double(observation.stamp_ns - *found_again_ns_) * 1e-9
                                        : std::numeric_limits<double>::infinity();
  if (track.retired) AddKeyframe(*track.retired);
  record.estimate.stamp_ns = observation.stamp_ns;
  record.estimate.features = track.points;
  record.estimate.inliers = track.inliers;
  record.estimate.restarted = track.restarted;
  const PlanarPose correction = keyframes_.empty() ? PlanarPose() : filter_.Mean() * keyframes_.back().Inverse();
  const Pose X_WC = correction.Lifted() * track.X_WC;
  if (track.tracked) {
    record.estimate.pose = X_WC;
    record.estimate.covariance = LiveCovariance(track, X_WC, record.since_loss_s);
    record.estimate.status = TrackingStatus::kTracking;
    started_ = true;
  } else {
    record.estimate.status = started_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (started_) record.estimate.predicted = X_WC;
  }
  if (track.retired) {
    present_ = BelowCamera(track.X_WC);
    present_covariance_ = track.covariance;
  }
  records_.push_back(record);
  return record.estimate;
}

std::vector<FrameEstimate> FloorSlam::Finish() {
  if (const std::optional<FloorKeyframe> last = tracker_.Finish()) AddKeyframe(*last);
  const std::vector<PlanarPose> path = filter_.SmoothPath();
  const std::vector<Eigen::Matrix3d> covariances = filter_.SmoothCovariances(path);
  std::vector<PlanarPose> corrections;
  for (size_t k = 0; k < path.size(); ++k) corrections.push_back(path[k] * keyframes_[k].Inverse());
  std::vector<FrameEstimate> estimates;
  for (const Record& record : records_) {
    FrameEstimate estimate = record.estimate;
    const auto keyframe = keyframe_of_id_.find(record.keyframe);
    if (record.aligned && keyframe != keyframe_of_id_.end()) {
      // Between two keyframes, interpolates their corrections.
      const size_t k = keyframe->second, next = std::min(k + 1, corrections.size() - 1);
      const Pose a = corrections[k].Lifted() * record.X_tracked, b = corrections[next].Lifted() * record.X_tracked;
      const double span = double(std::max<int64_t>(1, keyframe_ns_[next] - keyframe_ns_[k]));
      const double s = std::clamp(double(estimate.stamp_ns - keyframe_ns_[k]) / span, 0.0, 1.0);
      estimate.pose = Interpolate(a, b, s);
      estimate.status = TrackingStatus::kTracking;
      estimate.predicted.reset();
      if (options_.use_map) {
        const PlanarPose here = BelowCamera(record.X_tracked);
        const PlanarPose from = keyframes_[k].Inverse() * here, back = keyframes_[next].Inverse() * here;
        const Eigen::Matrix3d since = filter_.MotionCovariance(from.position.norm(), record.since_keyframe);
        estimate.covariance = Spatial(*estimate.pose,
                                      (1 - s) * Compose(covariances[k], from, since) +
                                          s * Compose(covariances[next], back, Eigen::Matrix3d::Zero()),
                                      record.since_loss_s);
      }
    }
    estimates.push_back(estimate);
  }
  return estimates;
}

}  // namespace gaitcam
