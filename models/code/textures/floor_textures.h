/// Floors. All wrap around without a seam, because floors repeat. Options must be complete (`CompleteTexture`).

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "models/code/textures/texture.h"

namespace gaitcam {

/// Wooden boards along x: one tone per board, growth rings and pores along the board, knots, staggered joints, dark
/// gaps, scuffs. `unit_m` is the width of a board.
cv::Mat MakePlanks(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Poured concrete: stains at all scales, pores, hairline cracks. `unit_m` is the size of the largest stains.
cv::Mat MakeConcrete(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Ceramic or stone tiles of edge `unit_m`: a tone and a piece of marbling per tile, grout, bevelled edges, chips.
cv::Mat MakeTiles(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Stone chips of many sizes, up to `unit_m` across, that do not overlap, in cement.
cv::Mat MakeTerrazzo(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Carpet tiles of edge `unit_m` laid in turned directions: pile, mottled yarn, flecks, worn patches.
cv::Mat MakeCarpet(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A robot soccer field in the middle of its carpet: 5.4 x 3.6 m within white lines `unit_m` wide, centre line and
/// circle, goal areas, penalty marks. The picture's x runs from goal to goal. It does not wrap around.
cv::Mat MakeField(const TextureOptions& options, cv::Size size, RandomStream& random);

}  // namespace gaitcam
