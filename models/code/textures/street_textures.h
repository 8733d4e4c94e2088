/// What stands along a street.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "models/code/textures/texture.h"

namespace gaitcam {

/// The front of a house: bricks, boards or plaster; storeys of about `unit_m` with windows and balconies; below them a
/// door and shop windows, shutters or notices, often under a sign. Each seed is another house. It does not wrap around.
cv::Mat MakeHouseFront(const TextureOptions& options, cv::Size size, RandomStream& random);

/// The lower half of a car, of the colour `rgb`: doors, wheels, lamps and a number plate. It does not wrap around, and
/// has its right proportions where it is stretched over six times its height.
cv::Mat MakeCarBody(const TextureOptions& options, cv::Size size, RandomStream& random);

}  // namespace gaitcam
