/// Jumps of an estimate: steps that the true motion makes impossible, found by one rule for all systems.

#pragma once

#include <cstddef>
#include <vector>

#include "results/scoring/association.h"

namespace gaitcam {

/// A step between two successive poses is a jump if it differs from the true one by more than this. The allowance grows
/// with the true motion in between, so with the frame interval and with the time for which a system was lost.
struct JumpRule {
  double position_m = 0.02;
  double rotation_deg = 2;
  double share = 0.25;  ///< Of the true step, in metres or degrees.
};

struct Jump {
  size_t to = 0;          ///< Index of the pair that it leads to.
  double position_m = 0;  ///< By how far the step is wrong,
  double rotation_deg = 0;
};

/// What a system says of its own restarts does not enter.
/// @param pairs aligned: the estimate in metres.
std::vector<Jump> FindJumps(const std::vector<PosePair>& pairs, const JumpRule& rule = {});

}  // namespace gaitcam
