/// When a keyframe odometry adds a keyframe: once the camera has moved, turned or lost sight of landmarks, at the next
/// frame that sees well. A frame blurred by a jerk would add poorly located landmarks and observe few of the known
/// ones.

#pragma once

#include <cstdint>
#include <optional>

#include "algorithms/core/fields.h"

namespace gaitcam {

struct KeyframePolicyOptions {
  using DescribedTag = void;

  double keyframe_displacement_px = 8;  ///< Median displacement by parallax since the last keyframe; 0: every frame.
  double keyframe_turn_deg = 12;        ///< Rotation since the last keyframe.
  double keyframe_overlap = 0.6;        ///< Inliers lately over the most in a frame since the last keyframe.
  /// A due keyframe waits so long for a frame that sees well and is sharp, as long again for one of these, and no
  /// longer. A time and no number of frames: what a walking camera loses sight of meanwhile does not depend on its
  /// rate.
  double max_wait_s = 0.33;
};

template <class Visitor>
void VisitFields(Visitor& visit, KeyframePolicyOptions& o) {
  visit("keyframe_displacement_px", o.keyframe_displacement_px, Between(0.0, 1000.0),
        "median displacement by parallax that makes a keyframe; 0: every frame");
  visit("keyframe_turn_deg", o.keyframe_turn_deg, Between(0.1, 180.0), "rotation that makes a keyframe");
  visit("keyframe_overlap", o.keyframe_overlap, Between(0.0, 1.0), "share of inliers left that makes a keyframe");
  visit("max_wait_s", o.max_wait_s, Between(0.0, 1000.0), "time to wait for a good frame, and again for a fair one");
}

/// A frame that has a pose, against the last keyframe.
struct SinceKeyframe {
  double displacement_px = 0;  ///< Median, by parallax.
  double turn_rad = 0;
  int inliers = 0;       ///< Of the frame.
  bool is_sharp = true;  ///< Against those around it.
};

class KeyframePolicy {
 public:
  /// @param min_inliers with fewer than twice as many a due keyframe does not wait
  KeyframePolicy(const KeyframePolicyOptions& options, int min_inliers)
      : options_(options), min_inliers_(min_inliers) {}

  /// To be asked once for every frame that has a pose, in order of time.
  /// @param stamp_ns the frame's
  bool IsKeyframe(int64_t stamp_ns, const SinceKeyframe& frame);

  /// To be told of every keyframe.
  void OnKeyframe(int inliers);

  /// Low-pass filtered number of inliers per frame since the last keyframe; 0 before the first such frame.
  double mean_inliers() const { return mean_inliers_; }
  /// The same, or before the first such frame the last keyframe's.
  double expected_inliers() const { return mean_inliers_ > 0 ? mean_inliers_ : keyframe_inliers_; }

 private:
  bool IsDue(const SinceKeyframe& frame) const;

  KeyframePolicyOptions options_;
  int min_inliers_;
  double keyframe_inliers_ = 0;  ///< Of the last keyframe.
  double mean_inliers_ = 0;
  double max_inliers_ = 0;               ///< Of a frame since the last keyframe.
  std::optional<int64_t> due_since_ns_;  ///< The first frame that would have been a keyframe; none: none is due.
};

}  // namespace gaitcam
