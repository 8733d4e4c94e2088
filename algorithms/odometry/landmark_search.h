/// Finds a map's landmarks in a frame: each near where it should be, or anywhere.

#pragma once

#include <vector>

#include "algorithms/odometry/landmark_map.h"

namespace gaitcam {

struct LandmarkSearchOptions {
  double radius = 0.17;       ///< Farthest distance from the prediction, normalised coordinates.
  double depth_sigmas = 2;    ///< ... and so many standard deviations of the prediction due to the unknown depth.
  double ratio = 0.8;         ///< Nearest over second nearest descriptor distance.
  double same_place = 0.006;  ///< Features nearer than this to the nearest one are no rivals of it: they are the same
                              ///< spot with another orientation or scale. Normalised coordinates.
};

/// Pairs landmarks that should be visible from `X_WC` with features of `view`. No feature is used twice.
std::vector<LandmarkMatch> SearchNear(const LandmarkMap& map, const FrameView& view, const Pose& X_WC,
                                      const LandmarkSearchOptions& options);

/// Pairs by descriptors alone, each other's nearest.
std::vector<LandmarkMatch> SearchAnywhere(const LandmarkMap& map, const FrameView& view, double ratio);

}  // namespace gaitcam
