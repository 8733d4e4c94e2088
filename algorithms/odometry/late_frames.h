/// Frames that got no pose when they came, and get one later for the final estimate alone: those that waited for a
/// first map, from the latest back to the first, and those that were missed between two that have poses.

#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/odometry/frame_records.h"
#include "algorithms/odometry/landmark_localizer.h"

namespace gaitcam {

class LateFrames {
 public:
  /// @param localizer,map,records of the same odometry; they must outlive this.
  LateFrames(const LandmarkLocalizer& localizer, const KeyframeMap& map, FrameRecords& records, uint64_t seed)
      : localizer_(localizer), map_(map), records_(records), random_(seed, "backlog") {}

  /// The frame that is recorded next got no pose. Beyond 60 in a row they are not kept: their features take memory.
  void Wait(const FrameView& view, int64_t stamp_ns) { Keep(view, stamp_ns, waiting_); }  ///< There is no map.
  void Miss(const FrameView& view, int64_t stamp_ns) { Keep(view, stamp_ns, missed_); }   ///< Not found in the map.

  /// Those that waited have nothing to do with the map to come.
  void DropWaiting() { waiting_.clear(); }
  /// Those that were missed since the last pose get none.
  void DropMissed() { missed_.clear(); }
  bool HasWaiting() const { return !waiting_.empty(); }

  /// Those that waited for the map can be localised in it now.
  /// @param first the map's first pose that was handed over, of the frame recorded last. @param inliers of it
  void BeginBacklog(const StampedPose& first, double median_depth, double inliers);

  /// Those that were missed lie between these two poses.
  void QueueMissed(const StampedPose& before, const StampedPose& after, double median_depth, double expected_inliers);

  /// One with every frame, so that none takes much longer than others.
  void LocalizeOne();
  /// All that are left.
  void LocalizeAll();

 private:
  struct Frame {
    size_t record = 0;  ///< Index in the records.
    FrameView view;
    int64_t stamp_ns = 0;
  };
  struct Backlog {
    std::vector<Frame> frames;  ///< In time order: the last one is next.
    StampedPose next_to;        ///< The pose found last, of the frame after it.
    double median_depth = 1, expected_inliers = 0;
    size_t present = 0, first = 0;  ///< Records of the map's first pose, and of the first frame that got one.
  };
  struct MissedFrame {
    Frame frame;
    StampedPose before, after;
    double median_depth = 1, expected_inliers = 0;
  };

  void Keep(const FrameView& view, int64_t stamp_ns, std::vector<Frame>& frames) const;
  void LocalizeWaiting();
  void LocalizeMissed();

  const LandmarkLocalizer& localizer_;
  const KeyframeMap& map_;
  FrameRecords& records_;
  RandomStream random_;  ///< A stream of its own: what is found later changes nothing of what is found at once.

  std::vector<Frame> waiting_;          ///< While there is no map.
  std::vector<Frame> missed_;           ///< Since the last frame that was localised in the map.
  Backlog backlog_;                     ///< What waited for the present map.
  std::deque<MissedFrame> found_late_;  ///< Missed ones, now between two poses.
};

}  // namespace gaitcam
