/// What a blurred frame costs and how exact it is, beside MuJoCo's bare loop and beside finer plain integration.

#pragma once

#include <string>
#include <vector>

#include "scenarios/code/files/scenario.h"
#include "sim/camera/picture_difference.h"

namespace gaitcam {

/// The frames of one walk with the longest blur.
struct LightRow {
  std::string name;
  int frames = 0;
  double blur_px = 0;                 ///< Path of the fastest point, median over the frames.
  double renders = 0, subframes = 0;  ///< Mean.
  GreyDifference sheared, sheared_edges, plain, plain_edges;
  double frame_s = 0;           ///< Time of a frame, median.
  double ratio = 0;             ///< Time of a frame over the bare loop's, as many renders as there are sub-frames.
  double ratio_with_truth = 0;  ///< With sharp twin, depth and blur vectors.
};

struct LightMeasurement {
  int frames = 8;           ///< How many of a walk.
  double longest_s = 20;    ///< Of a walk, only so much is looked at.
  bool convergence = true;  ///< Against plain integration four times as fine, which takes the most time.
};

/// @throws what a simulation throws.
LightRow MeasureLight(const ResolvedScenario& scenario, const LightMeasurement& options);

}  // namespace gaitcam
