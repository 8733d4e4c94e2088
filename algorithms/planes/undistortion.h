/// Images as an ideal pinhole camera would have taken them.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/camera.h"

namespace gaitcam {

class Undistortion {
 public:
  explicit Undistortion(const CameraModel& lens);

  /// The camera of the undistorted images: the lens's intrinsics without its distortion.
  const CameraModel& camera() const { return camera_; }

  /// @param image CV_8UC1 or CV_8UC3. @returns CV_8UC1; the image's own pixels where it is grey and nothing is
  /// distorted.
  /// @throws BadInput if the image's size is not the camera's.
  cv::Mat Grey(const cv::Mat& image) const;

 private:
  CameraModel camera_;
  cv::Mat map_u_, map_v_;  ///< Of cv::remap; empty if nothing is distorted.
};

}  // namespace gaitcam
