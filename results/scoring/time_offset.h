/// By how much an estimate's stamps are late.

#pragma once

#include <vector>

#include "algorithms/core/trajectory.h"
#include "results/scoring/association.h"

namespace gaitcam {

/// What must be subtracted from the estimate's stamps so that its turning agrees best with the true turning, ms.
/// Turning between successive poses needs no alignment of worlds and no scale. Least squares over offsets within
/// `reach_ms`, the truth being interpolated (SmoothPoseAt); steps over gaps are left out.
/// @param pairs before any offset was applied. @returns NaN if the motion does not determine it: if the turning differs
/// from one offset to the next by less than it is wrong in any case.
double EstimateTimeOffsetMs(const std::vector<PosePair>& pairs, const Trajectory& truth, double reach_ms = 100);

}  // namespace gaitcam
