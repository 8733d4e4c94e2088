/// An odometry's answers, frame by frame, each pose held relative to the keyframe that was the latest when it was
/// found: when bundle adjustment moves a keyframe later, the frames that refer to it move along.

#pragma once

#include <cstddef>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/odometry/keyframe_map.h"
#include "algorithms/odometry/landmark_localizer.h"

namespace gaitcam {

class FrameRecords {
 public:
  /// Appends the answer to the next frame. Its pose, if it has one, refers to the map's latest keyframe, or to none
  /// while the map has none: then it stays as it is.
  void Add(const FrameEstimate& answer, const KeyframeMap& map);

  /// A pose that was found later for an earlier frame.
  void SetPose(size_t frame, const LandmarkPose& pose, const KeyframeMap& map);

  /// If `from` marks a restart, `to` marks it instead.
  void MoveRestart(size_t from, size_t to);

  /// Frames recorded; the index of the next one.
  size_t size() const { return records_.size(); }

  /// The final estimate, by the map's keyframes as they are now.
  /// @param scales of every keyframe, what the motion from there to the next is multiplied by; empty: nothing is.
  std::vector<FrameEstimate> Finish(const KeyframeMap& map, const std::vector<double>& scales) const;

 private:
  struct Record {
    FrameEstimate answer;
    int keyframe = -1;  ///< -1: none.
    Pose X_KC;
  };
  static void Attach(Record& record, const Pose& X_WC, const KeyframeMap& map);

  std::vector<Record> records_;
};

}  // namespace gaitcam
