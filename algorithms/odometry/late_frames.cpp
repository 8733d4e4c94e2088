#include "algorithms/odometry/late_frames.h"

#include <optional>
#include <utility>

namespace gaitcam {

void LateFrames::Keep(const FrameView& view, int64_t stamp_ns, std::vector<Frame>& frames) const {
  constexpr size_t kMaxFrames = 60;
  if (frames.size() < kMaxFrames) frames.push_back({records_.size(), view, stamp_ns});
}

void LateFrames::BeginBacklog(const StampedPose& first, double median_depth, double inliers) {
  const size_t present = records_.size() - 1;
  backlog_ = {std::move(waiting_), first, median_depth, inliers, present, present};
  waiting_.clear();
}

void LateFrames::QueueMissed(const StampedPose& before, const StampedPose& after, double median_depth,
                             double expected_inliers) {
  for (Frame& frame : missed_) found_late_.push_back({std::move(frame), before, after, median_depth, expected_inliers});
  missed_.clear();
}

void LateFrames::LocalizeOne() {
  if (!found_late_.empty()) {
    LocalizeMissed();
  } else if (!backlog_.frames.empty()) {
    LocalizeWaiting();
  }
}

void LateFrames::LocalizeAll() {
  while (!found_late_.empty() || !backlog_.frames.empty()) LocalizeOne();
}

void LateFrames::LocalizeWaiting() {
  const Frame frame = std::move(backlog_.frames.back());
  backlog_.frames.pop_back();
  PosePrediction prediction;
  prediction.X_WC = backlog_.next_to.pose;
  prediction.expected_inliers = backlog_.expected_inliers;
  prediction.prior = localizer_.PredictPosition(prediction.X_WC.translation, backlog_.next_to.stamp_ns - frame.stamp_ns,
                                                backlog_.median_depth);
  const auto localized = localizer_.LocalizeWithNoise(map_, frame.view, prediction, 1, random_);
  if (localized && LandmarkLocalizer::IsWithinReach(*prediction.prior, localized->X_WC)) {
    backlog_.next_to = {frame.stamp_ns, localized->X_WC};
    backlog_.first = frame.record;
    records_.SetPose(frame.record, *localized, map_);
  }
  if (backlog_.frames.empty()) records_.MoveRestart(backlog_.present, backlog_.first);
}

void LateFrames::LocalizeMissed() {
  const MissedFrame missed = std::move(found_late_.front());
  found_late_.pop_front();
  const auto localized =
      localizer_.LocalizeBetween(map_, missed.frame.view, missed.frame.stamp_ns, missed.before, missed.after,
                                 missed.median_depth, missed.expected_inliers, random_);
  if (localized) records_.SetPose(missed.frame.record, *localized, map_);
}

}  // namespace gaitcam
