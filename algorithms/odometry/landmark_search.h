/// Data association of a map's landmarks with a frame's features: guided by a predicted pose, or by descriptors alone.

#pragma once

#include <vector>

#include "algorithms/odometry/keyframe_map.h"

namespace gaitcam {

struct LandmarkSearchOptions {
  double radius = 0.17;       ///< Search radius around a landmark's projection, normalised image coordinates ...
  double depth_sigmas = 2;    ///< ... to which so many standard deviations of it due to the depth are added.
  double rivals = 0;          ///< Radius within which features are rivals in the ratio test, if larger; likewise.
  double ratio = 0.8;         ///< Nearest over second nearest descriptor distance.
  double same_point = 0.006;  ///< Features nearer to each other than this are one point with several orientations or
                              ///< scales: no rivals in the ratio test. Normalised image coordinates.
};

/// Matches landmarks that should be visible from `X_WC` with features of `view`. No feature is used twice.
std::vector<LandmarkMatch> SearchNear(const KeyframeMap& map, const FrameView& view, const Pose& X_WC,
                                      const LandmarkSearchOptions& options);

/// Matches by descriptors alone, mutual nearest neighbours that pass the ratio test.
std::vector<LandmarkMatch> SearchAnywhere(const KeyframeMap& map, const FrameView& view, double ratio);

}  // namespace gaitcam
