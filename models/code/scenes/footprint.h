/// What the things of a scene cover of its floor.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "models/code/scenes/scene.h"

namespace gaitcam {

/// The convex area that a box covers of the floor, m; nothing if it is in nobody's way: it does not collide, is as flat
/// as a print, or hangs above `high_m`.
std::vector<cv::Point2f> Footprint(const SceneBox& box, double high_m);

}  // namespace gaitcam
