#include "algorithms/core/estimate.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

std::string ToString(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kInitializing: return "initializing";
    case TrackingStatus::kTracking: return "tracking";
    case TrackingStatus::kLost: return "lost";
  }
  GAITCAM_ASSERT(false);
  return {};
}

Trajectory Estimate::ToTrajectory() const { return PosesOf(frames); }

Trajectory PosesOf(const std::vector<FrameEstimate>& frames) {
  Trajectory trajectory;
  for (const FrameEstimate& frame : frames) {
    if (frame.pose) trajectory.push_back({frame.stamp_ns + frame.pose_delay_ns, *frame.pose});
  }
  return trajectory;
}

}  // namespace gaitcam
