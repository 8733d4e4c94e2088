/// Intrinsics out of the floor: the true depth of a pixel and the true pose of the camera say where in the world the
/// point seen lies, if the intrinsics are right. Points of the floor must come out at z = 0.

#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// What the floor says of a camera, and how certain that is (one standard deviation).
struct FloorIntrinsics {
  double fx = 0, fy = 0, fx_std = 0, fy_std = 0;  ///< px
  double rms_m = 0;                               ///< Height of the floor's points under these intrinsics.
  int points = 0;
};

/// Collects pixels of frames, then fits. The height of the point at normalised image coordinates (x, y) and depth d is
///   z = t_z + d (R_20 x + R_21 y + R_22),    X_WC = (R, t),
/// linear in the corrections x = s_x x^ + o_x, y = s_y y^ + o_y of what the given camera says: least squares, repeated
/// with what then lies near the floor. f_x is known as well as the camera rolls, f_y as it looks along the floor.
class FloorFit {
 public:
  explicit FloorFit(const CameraModel& camera) : camera_(camera) {}

  /// @param depth CV_32FC1, m along the optical axis.
  void Add(const Pose& X_WC, const cv::Mat& depth);
  /// @returns nothing if too little floor was seen.
  std::optional<FloorIntrinsics> Fit() const;

  /// Median height of what one frame shows of the floor, m, with the camera as given; nothing if it shows too little.
  static std::optional<double> FloorHeight(const CameraModel& camera, const Pose& X_WC, const cv::Mat& depth);

 private:
  struct Sample {
    double x, y, depth, r0, r1, r2, t_z;
  };
  CameraModel camera_;
  std::vector<Sample> samples_;
};

}  // namespace gaitcam
