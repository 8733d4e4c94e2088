/// Intrinsics from the floor: true depth of a pixel, true pose of the camera and intrinsics give the position of the
/// observed point in the world. With the right intrinsics, points of the floor lie at z = 0.

#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// Estimated focal lengths and their standard deviations.
struct FloorIntrinsics {
  double fx = 0, fy = 0, fx_std = 0, fy_std = 0;  ///< px
  double rms_m = 0;                               ///< Height of the floor's points under these intrinsics.
  int points = 0;
};

/// Collects pixels of frames, then fits. The height of the point at normalised image coordinates (x, y) and depth d is
///   z = t_z + d (R_20 x + R_21 y + R_22),    X_WC = (R, t),
/// linear in the corrections x = s_x x^ + o_x, y = s_y y^ + o_y of the given camera's coordinates: least squares,
/// repeated with the points that then lie near the floor. f_x is observable through roll of the camera, f_y through
/// views along the floor.
class FloorFit {
 public:
  explicit FloorFit(const CameraModel& camera) : camera_(camera) {}

  /// @param depth CV_32FC1, m along the optical axis.
  void Add(const Pose& X_WC, const cv::Mat& depth);
  /// @returns nothing if too little of the floor was observed.
  std::optional<FloorIntrinsics> Fit() const;

  /// Median height of the floor's points in one frame, m, with the camera as given; nothing if there are too few.
  static std::optional<double> FloorHeight(const CameraModel& camera, const Pose& X_WC, const cv::Mat& depth);

 private:
  struct Sample {
    double x, y, depth, r0, r1, r2, t_z;
  };
  CameraModel camera_;
  std::vector<Sample> samples_;
};

}  // namespace gaitcam
