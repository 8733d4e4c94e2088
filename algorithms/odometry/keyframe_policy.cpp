#include "algorithms/odometry/keyframe_policy.h"

#include <algorithm>

#include "algorithms/core/units.h"

namespace gaitcam {

bool KeyframePolicy::IsKeyframe(int64_t stamp_ns, const SinceKeyframe& frame) {
  const double count = frame.inliers;
  constexpr double kGain = 0.1;  // of the low-pass filter
  mean_inliers_ = mean_inliers_ > 0 ? (1 - kGain) * mean_inliers_ + kGain * count : count;
  max_inliers_ = std::max(max_inliers_, count);
  if (options_.keyframe_displacement_px == 0) return true;
  if (!due_since_ns_ && !IsDue(frame)) return false;
  if (!due_since_ns_) due_since_ns_ = stamp_ns;
  const double waited_s = 1e-9 * double(stamp_ns - *due_since_ns_);
  const bool is_nearly_lost = count < 2 * min_inliers_;
  if (is_nearly_lost || waited_s >= 2 * options_.max_wait_s) return true;
  const bool sees_well = count >= mean_inliers_;
  return waited_s >= options_.max_wait_s ? sees_well || frame.is_sharp : sees_well && frame.is_sharp;
}

bool KeyframePolicy::IsDue(const SinceKeyframe& frame) const {
  return mean_inliers_ < options_.keyframe_overlap * max_inliers_ ||
         frame.turn_rad > options_.keyframe_turn_deg * kRadPerDeg ||
         frame.displacement_px > options_.keyframe_displacement_px;
}

void KeyframePolicy::OnKeyframe(int inliers) {
  keyframe_inliers_ = inliers;
  mean_inliers_ = max_inliers_ = 0;
  due_since_ns_.reset();
}

}  // namespace gaitcam
