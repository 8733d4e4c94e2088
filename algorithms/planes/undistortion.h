/// Images as an ideal pinhole camera would have taken them, all rows at once.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>

#include "algorithms/core/camera.h"

namespace gaitcam {

/// Along which ray a rolling shutter saw, when a row was exposed, what lies along a ray at the frame's stamp.
/// @param ray_S of depth 1, in the camera's frame at the stamp
/// @param row   0: the first, 1: the last
/// @returns in the camera's frame when that row was exposed, of any length
using SeenAtRow = std::function<Eigen::Vector3d(const Eigen::Vector3d& ray_S, double row)>;

class Undistortion {
 public:
  explicit Undistortion(const CameraModel& lens);

  /// The camera of the undistorted images: the lens's intrinsics without its distortion.
  const CameraModel& camera() const { return camera_; }

  /// @param image CV_8UC1 or CV_8UC3. @returns CV_8UC1; the image's own pixels where it is grey and nothing is
  /// distorted.
  /// @param seen of a rolling shutter: the image is given as if all rows had been exposed at the stamp. Empty: it is
  /// left as it rolled.
  /// @throws BadInput if the image's size is not the camera's.
  cv::Mat Grey(const cv::Mat& image, const SeenAtRow& seen = {}) const;

 private:
  void MapRolling(const SeenAtRow& seen, cv::Mat& map_u, cv::Mat& map_v) const;

  CameraModel lens_;
  CameraModel camera_;
  cv::Mat map_u_, map_v_;  ///< Of cv::remap; empty if nothing is distorted.
};

}  // namespace gaitcam
