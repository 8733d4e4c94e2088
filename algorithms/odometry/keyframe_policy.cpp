#include "algorithms/odometry/keyframe_policy.h"

#include <algorithm>

#include "algorithms/core/units.h"

namespace gaitcam {

bool KeyframePolicy::IsKeyframe(const SinceKeyframe& frame) {
  const double count = frame.inliers;
  constexpr double kGain = 0.1;  // of the low-pass filter
  mean_inliers_ = mean_inliers_ > 0 ? (1 - kGain) * mean_inliers_ + kGain * count : count;
  max_inliers_ = std::max(max_inliers_, count);
  if (options_.keyframe_displacement_px == 0) return true;
  if (waiting_frames_ == 0 && !IsDue(frame)) return false;
  ++waiting_frames_;
  const bool is_nearly_lost = count < 2 * min_inliers_;
  if (is_nearly_lost || waiting_frames_ > 2 * options_.max_wait_frames) return true;
  const bool sees_well = count >= mean_inliers_;
  return waiting_frames_ > options_.max_wait_frames ? sees_well || frame.is_sharp : sees_well && frame.is_sharp;
}

bool KeyframePolicy::IsDue(const SinceKeyframe& frame) const {
  return mean_inliers_ < options_.keyframe_overlap * max_inliers_ ||
         frame.turn_rad > options_.keyframe_turn_deg * kRadPerDeg ||
         frame.displacement_px > options_.keyframe_displacement_px;
}

void KeyframePolicy::OnKeyframe(int inliers) {
  keyframe_inliers_ = inliers;
  mean_inliers_ = max_inliers_ = 0;
  waiting_frames_ = 0;
}

}  // namespace gaitcam
