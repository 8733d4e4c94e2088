/// What a SLAM system says: one entry per frame it was given, lost or not.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/floor_picture.h"
#include "algorithms/core/place_graph.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

enum class TrackingStatus {
  kInitializing,  ///< Not enough seen yet for a first pose.
  kTracking,      ///< `pose` is set.
  kLost,          ///< Had a pose before, has none now.
};

/// "initializing", "tracking", "lost".
std::string ToString(TrackingStatus status);

/// The answer to one observation. The system chooses its world frame W and, if monocular, its scale.
struct FrameEstimate {
  int64_t stamp_ns = 0;
  TrackingStatus status = TrackingStatus::kInitializing;
  std::optional<Pose> pose;  ///< X_WC of the left camera, present exactly when tracking.
  bool restarted = false;    ///< True when W or its scale was chosen anew at this frame: a marked jump.
  int features = 0;          ///< Found in this frame.
  int inliers = 0;           ///< Of those, agreeing with the pose.
};

/// All answers of one run, in frame order.
struct Estimate {
  std::vector<FrameEstimate> frames;
  std::string failure;                ///< Why the system stopped working, in one line; empty if it did not.
  std::optional<FloorPicture> floor;  ///< The floor as it was mapped, in the plane z = 0 of the poses' world.
  std::optional<PlaceGraph> places;   ///< The topological map, of systems that make one.
  std::vector<double> track_ms;       ///< Wall time spent per frame; the one part that differs from run to run.

  /// The frames that have a pose.
  Trajectory ToTrajectory() const;
};

}  // namespace gaitcam
