/// The pose of a calibrated camera from points of known position (perspective-n-point).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {

/// A known point and its image.
struct PointSighting {
  Eigen::Vector3d p_W;
  Eigen::Vector2d xy;  ///< Normalised image coordinates (undistorted, focal length 1).
};

/// Up to four poses X_WC that project three points exactly (Ke and Roumeliotis, CVPR 2017; OpenCV's implementation).
std::vector<Pose> SolveThreePoint(const std::vector<PointSighting>& three);

/// Squared reprojection error in normalised coordinates; infinity for a point behind the camera.
double ReprojectionError2(const Pose& X_WC, const PointSighting& sighting);

/// Least squares over the given sightings, by Gauss-Newton with Huber's weights beyond `huber`.
/// @returns the refined pose, or `X_WC` itself where the problem is singular.
Pose RefineAbsolutePose(const std::vector<PointSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                        double huber);

/// Three-point RANSAC, then refinement over the inliers.
/// @param options threshold in normalised coordinates (pixels / focal length)
/// @param guess   a hypothesis that is judged first
/// @returns no inliers if fewer than 4 sightings agree. Never NaN.
RansacResult<Pose> EstimateAbsolutePose(const std::vector<PointSighting>& sightings, const RansacOptions& options,
                                        RandomStream& random, const std::optional<Pose>& guess = {});

}  // namespace gaitcam
