/// Where a camera stands that sees landmarks of a map: they are searched, three of them make a hypothesis, and all that
/// agree with it, each as exactly as its depth is known, decide. Depths that are not known constrain the turn alone.

#pragma once

#include <optional>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/odometry/landmark_map.h"
#include "algorithms/odometry/landmark_search.h"

namespace gaitcam {

struct LandmarkPoseOptions {
  LandmarkSearchOptions search;  ///< Near a predicted pose.
  double threshold = 0.01;       ///< Largest error of an inlier of a hypothesis, normalised coordinates.
  double outlier_sigmas = 3;     ///< A sighting further from its projection is not believed.
  int min_inliers = 15;          ///< With fewer there is no pose.
  double confidence = 0.999;     ///< Of the hypotheses, as of every RANSAC.
  int iterations = 100;
};

struct LandmarkPose {
  Pose X_WC;
  std::vector<LandmarkMatch> inliers;
};

/// Searches landmarks near where they should be, else anywhere; then once more, closely, from the pose found.
/// @param noise times so much worse than `view.sigma` says the features may be placed
/// @returns nothing where no pose is agreed upon. Never NaN.
std::optional<LandmarkPose> PlaceByLandmarks(const LandmarkMap& map, const FrameView& view, const Pose& prediction,
                                             double noise, const LandmarkPoseOptions& options, RandomStream& random);

/// The landmarks that a frame sees which stands at `view.X_WC`, whoever has said so.
std::vector<LandmarkMatch> FindLandmarks(const LandmarkMap& map, const FrameView& view,
                                         const LandmarkPoseOptions& options);

/// Median of the sightings' distances from their projections over what `view.sigma` would make it: above 1 the frame
/// places its features worse than others of their size, by blur that its keypoints do not tell.
double NoiseFactor(const LandmarkMap& map, const FrameView& view, const std::vector<LandmarkMatch>& matches);

}  // namespace gaitcam
