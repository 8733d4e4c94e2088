/// The floor as one keyframe shows it, rectified to a bird's-eye image in the frame on the floor below the camera.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/floor_picture.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/planes/image_pyramid.h"

namespace gaitcam {

struct FloorPatch {
  struct Point {
    Eigen::Vector2d p;  ///< m
    float intensity = 0;
  };
  struct Sample {
    float intensity = 0;
    Eigen::Vector2f slope{0, 0};  ///< Grey levels per metre along x and y.
  };

  /// A level of the patch's pyramid.
  struct Level {
    cv::Mat intensity;  ///< CV_8UC1, column i at x = x0 + i cell, row j at y = y0 + j cell; 0: not visible.
    double cell_m = 0, x0 = 0, y0 = 0;
    std::vector<Point> match;  ///< Cells of large gradient, well spread.

    /// Bilinear; nothing unless all four neighbours are visible.
    std::optional<Sample> At(const Eigen::Vector2d& p) const;
  };
  static constexpr int kLevels = 3;  ///< Cells of each level are twice as wide as those of the one before.

  std::vector<Level> levels;     ///< None if no floor is visible.
  Eigen::Vector2d middle{0, 0};  ///< Centroid of the visible cells.

  bool empty() const { return levels.empty(); }
  double width_m() const;  ///< Of the larger side.
  double bytes() const;

  /// Pixels are averaged to cells (by the pyramid), so that near floor is not aliased.
  /// @param mask CV_8UC1, not zero where the floor is. @param X_WC only height and tilt matter. @param range_m floor
  /// farther from the camera is left out. @param match_points of level 0, at most.
  static FloorPatch Of(const ImagePyramid& image, const cv::Mat& mask, const CameraModel& camera, const Pose& X_WC,
                       double cell_m, double range_m, int match_points);
};

/// The map of a floor (thesis 6.5.2: map and mask): the mean over all patches of each cell.
/// @param poses of the frames below the camera, one per patch. @return empty if all patches are.
FloorPicture DrawFloor(const std::vector<FloorPatch>& patches, const std::vector<PlanarPose>& poses, double cell_m);

}  // namespace gaitcam
