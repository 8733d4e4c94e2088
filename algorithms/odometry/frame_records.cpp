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
  record.answer.inliers = int(pose.inliers.size());
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

std::vector<FrameEstimate> FrameRecords::Finish(const KeyframeMap& map) const {
  std::vector<FrameEstimate> frames;
  for (const Record& record : records_) {
    frames.push_back(record.answer);
    if (record.keyframe >= 0) frames.back().pose = map.keyframes()[size_t(record.keyframe)] * record.X_KC;
  }
  return frames;
}

}  // namespace gaitcam
