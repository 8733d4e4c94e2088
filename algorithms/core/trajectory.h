/// A path through space: stamped poses in time order.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

/// Poses X_WC, stamps strictly increasing.
using Trajectory = std::vector<StampedPose>;

/// Sum of the distances between successive positions, m.
double PathLength(const Trajectory& trajectory);

/// @returns the pose at `stamp_ns` by interpolation, or nothing outside the trajectory's span.
std::optional<Pose> PoseAt(const Trajectory& trajectory, int64_t stamp_ns);

/// The same by a cubic through the two entries before and the two after, positions and rotations apart: a gait's sway,
/// sampled at 10 Hz, is met to some 0.1 mm, where the straight line of PoseAt misses by a millimetre. Near an end, or
/// beside a gap of more than `max_gap_ns`, of fewer entries.
/// @returns nothing outside the trajectory's span, or within such a gap.
std::optional<Pose> SmoothPoseAt(const Trajectory& trajectory, int64_t stamp_ns, int64_t max_gap_ns);

/// @throws BadInput naming `what` and the first entry whose stamp does not increase.
void CheckStampsIncrease(const Trajectory& trajectory, const std::string& what);

}  // namespace gaitcam
