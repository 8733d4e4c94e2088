/// Pairs of a stereo rig in a rendered room, before and after a step, with SIFT matched over the four images.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenarios/code/experiments/stereo_trials.h"

namespace gaitcam {

/// A step of the rig as its images show it. `sightings.X_AB` is the true motion.
struct RenderedStep {
  SceneSightings sightings;  ///< RANSAC's inliers; covariances: SIFT's scale squared (Valencia, section 2.3.1).
  int matched = 0;           ///< Over all four images, before RANSAC.
};

/// Steps from places and into directions drawn by the seed, in a scene that models/ has; images are sharp, with the
/// simulated sensor's noise of 10 ms. Those with fewer than 12 inliers are drawn anew.
/// @throws BadInput, MissingResource as the scene and the renderer do.
std::vector<RenderedStep> RenderSteps(const std::string& scene, const StereoRig& rig, int steps, int max_points,
                                      uint64_t seed);

}  // namespace gaitcam
