/// Surfaces of rooms and furniture.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "models/code/textures/texture.h"

namespace gaitcam {

/// A painted wall: slow shading, faint roller texture of grain `unit_m`, a few marks. Wraps around.
cv::Mat MakePaint(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A board of furniture: growth rings and fibres along y. Wraps around.
cv::Mat MakeWood(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Cloth of clothes that are worn: threads that cross, slubs, and soft folds of about `unit_m`. Wraps around.
cv::Mat MakeCloth(const TextureOptions& options, cv::Size size, RandomStream& random);

/// The side of a packing carton: kraft paper, the shadow of its flutes, a strip of tape, printed marks and a label.
cv::Mat MakeCardboard(const TextureOptions& options, cv::Size size, RandomStream& random);

/// One tier of a bookshelf: spines of different width, height and colour with titles. `unit_m` is the usual thickness.
cv::Mat MakeBooks(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A door in its frame: panels, a handle, a sign.
cv::Mat MakeDoor(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A suspended ceiling: panels of edge `unit_m` with pinholes, some of them lamps. Wraps around.
cv::Mat MakeCeiling(const TextureOptions& options, cv::Size size, RandomStream& random);

}  // namespace gaitcam
