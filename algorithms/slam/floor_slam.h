/// Monocular SLAM over a flat floor from the homographies of the floor plane, with an intensity map of it (thesis,
/// chapter 6): a tracker aligns each frame with a keyframe; a Rao-Blackwellised particle filter maps the keyframes and
/// closes loops where the camera returns to mapped floor.

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/planes/floor_filter.h"
#include "algorithms/planes/floor_tracker.h"

namespace gaitcam {

struct FloorSlamOptions {
  using DescribedTag = void;
  FloorTrackerOptions tracker;
  FloorFilterOptions filter;
  bool use_map = true;  ///< False: dead reckoning by the tracker; the map is drawn but closes no loop.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorSlamOptions& o) {
  visit("tracker", o.tracker, Nested(), "frame by frame");
  visit("filter", o.filter, Nested(), "map and trajectory");
  visit("use_map", o.use_map, Nested(), "false: tracking alone, the map corrects nothing");
}

class FloorSlam {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands.
  FloorSlam(const Calibration& calibration, const FloorSlamOptions& options, uint64_t seed);

  /// World W: z = 0 is the floor, z up, the origin below the first camera, x along its view; metres.
  FrameEstimate Track(const Observation& observation);
  /// Every frame on the smoothed trajectory, corrections interpolated between keyframes.
  std::vector<FrameEstimate> Finish();
  FloorPicture Floor() const { return filter_.Map(filter_.SmoothPath()); }

  const FloorFilter& filter() const { return filter_; }
  const std::vector<int64_t>& keyframe_stamps() const { return keyframe_ns_; }

 private:
  struct Record {
    FrameEstimate estimate;
    Pose X_tracked;        ///< By the tracker.
    bool aligned = false;  ///< With a keyframe ...
    int keyframe = 0;      ///< ... of this FloorKeyframe::id.
  };
  void AddKeyframe(const FloorKeyframe& keyframe);

  FloorSlamOptions options_;
  FloorTracker tracker_;
  FloorFilter filter_;
  std::vector<Record> records_;
  bool started_ = false;
  std::vector<PlanarPose> keyframes_;  ///< By the tracker.
  std::vector<int64_t> keyframe_ns_;
  std::map<int, size_t> keyframe_of_id_;  ///< Index of the retired ones.
};

}  // namespace gaitcam
