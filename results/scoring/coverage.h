/// How much of a run has a pose.

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/association.h"

namespace gaitcam {

inline double SecondsBetween(int64_t from_ns, int64_t to_ns) { return double(to_ns - from_ns) * 1e-9; }

struct Coverage {
  double ratio = 0;                 ///< Part of the frames (of the time span, if frames are unknown) with a pair.
  double time_to_first_pose_s = 0;  ///< NaN without a pose, or if frames are unknown.
  size_t frames = 0;                ///< Given to the system; poses of the estimate, if frames are unknown.
  size_t tracked = 0;               ///< With a pose.
  size_t initializing = 0;          ///< Before the first pose.
  size_t lost = 0;                  ///< Without a pose after the first one.
  size_t restarts = 0;              ///< New worlds after the first, as the system says; no other score depends on it.
  double inlier_ratio = 0;          ///< Inliers over matches, mean over the frames with a pose; NaN if it says neither.
  bool frames_known = false;
};

/// @param keyframes_only if so (Estimate::keyframes_only), frames between two poses count as covered.
/// @param frame_stamps of all frames that the system was given, in order. Empty if they are unknown (two trajectory
/// files are compared): then `ratio` is the part of the true time span in which successive pairs are no farther apart
/// than 2.5 times their median distance.
Coverage MeasureCoverage(const std::vector<FrameEstimate>& answer, bool keyframes_only, const Trajectory& truth,
                         const std::vector<PosePair>& pairs, const std::vector<int64_t>& frame_stamps);

}  // namespace gaitcam
