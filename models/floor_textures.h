/// Floors. All wrap around without a seam, because floors repeat. Options must be complete (`CompleteTexture`).

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "models/texture.h"

namespace gaitcam {

/// Wooden boards along x: one tone per board, growth rings and pores along the board, knots, staggered joints, dark
/// gaps, scuffs. `unit_m` is the width of a board.
cv::Mat MakePlanks(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Poured concrete: stains at all scales, pores, hairline cracks. `unit_m` is the size of the largest stains.
cv::Mat MakeConcrete(const TextureOptions& options, cv::Size size, RandomStream& random);

}  // namespace gaitcam
