#include "algorithms/slam/floor_slam.h"

#include <algorithm>

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

}  // namespace

FloorSlam::FloorSlam(const Calibration& calibration, const FloorSlamOptions& options, uint64_t seed)
    : options_(options), tracker_(calibration, options.tracker), filter_(FilterOf(options), seed) {}

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

FrameEstimate FloorSlam::Track(const Observation& observation) {
  const FloorTrack track = tracker_.Track(observation);
  Record record;
  record.X_tracked = track.X_WC;
  record.aligned = track.tracked || track.tentative;
  record.keyframe = track.keyframe;
  if (track.retired) AddKeyframe(*track.retired);
  record.estimate.stamp_ns = observation.stamp_ns;
  record.estimate.features = track.points;
  record.estimate.inliers = track.inliers;
  record.estimate.restarted = track.restarted;
  if (track.tracked) {
    const PlanarPose correction = keyframes_.empty() ? PlanarPose() : filter_.Mean() * keyframes_.back().Inverse();
    record.estimate.pose = correction.Lifted() * track.X_WC;
    record.estimate.status = TrackingStatus::kTracking;
    started_ = true;
  } else {
    record.estimate.status = started_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  }
  records_.push_back(record);
  return record.estimate;
}

std::vector<FrameEstimate> FloorSlam::Finish() {
  if (const std::optional<FloorKeyframe> last = tracker_.Finish()) AddKeyframe(*last);
  const std::vector<PlanarPose> path = filter_.SmoothPath();
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
      estimate.pose = Interpolate(a, b, std::clamp(double(estimate.stamp_ns - keyframe_ns_[k]) / span, 0.0, 1.0));
      estimate.status = TrackingStatus::kTracking;
    }
    estimates.push_back(estimate);
  }
  return estimates;
}

}  // namespace gaitcam
