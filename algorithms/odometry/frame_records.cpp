#include "algorithms/odometry/frame_records.h"

#include <utility>

namespace gaitcam {

void FrameRecords::Add(const FrameEstimate& answer, const KeyframeMap& map) {
  records_.push_back({answer, -1, Pose()});
  if (answer.pose) Attach(records_.back(), *answer.pose, map);
}

void FrameRecords::SetPose(size_t frame, const LandmarkPose& pose, const KeyframeMap& map) {
  Record& record = records_[frame];
  record.answer.status = TrackingStatus::kTracking;
  record.answer.predicted.reset();
  record.answer.inliers = int(pose.inliers.size());
  record.answer.matches = pose.matches;
  Attach(record, pose.X_WC, map);
}

void FrameRecords::Attach(Record& record, const Pose& X_WC, const KeyframeMap& map) {
  record.answer.pose = X_WC;
  record.keyframe = map.LatestKeyframe();
  if (record.keyframe >= 0) record.X_KC = map.keyframes()[size_t(record.keyframe)].Inverse() * X_WC;
}

void FrameRecords::MoveRestart(size_t from, size_t to) {
  if (records_[from].answer.restarted) std::swap(records_[from].answer.restarted, records_[to].answer.restarted);
}

std::vector<FrameEstimate> FrameRecords::Finish(const KeyframeMap& map, const std::vector<double>& scales) const {
  const std::vector<Pose>& keyframes = map.keyframes();
  const auto scale = [&](size_t keyframe) { return scales.empty() ? 1 : scales[keyframe]; };
  std::vector<Pose> scaled = keyframes;
  Eigen::Vector3d before = Eigen::Vector3d::Zero(), at = Eigen::Vector3d::Zero();  // in the map's unit, and scaled
  for (size_t k = 0; k < scaled.size(); ++k) {
    at += scale(k == 0 ? 0 : k - 1) * (keyframes[k].translation - before);
    before = keyframes[k].translation;
    scaled[k].translation = at;
  }
  std::vector<FrameEstimate> frames;
  for (const Record& record : records_) {
    frames.push_back(record.answer);
    if (record.keyframe < 0) continue;
    const size_t k = size_t(record.keyframe);
    frames.back().pose = scaled[k] * Pose(record.X_KC.rotation, scale(k) * record.X_KC.translation);
  }
  return frames;
}

}  // namespace gaitcam
