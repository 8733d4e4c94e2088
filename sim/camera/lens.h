/// A lens with distortion, or with pixels that are not square: an ideal wider camera is rendered and its image warped.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/camera.h"

namespace gaitcam {

class Lens {
 public:
  /// @throws BadOption if the distortion is not invertible within the image, or needs a rendered image more than four
  /// times as wide or high.
  explicit Lens(const CameraModel& camera);

  const CameraModel& camera() const { return camera_; }
  /// The ideal camera with square pixels that is rendered; the camera itself if that has no distortion.
  const CameraModel& pinhole() const { return pinhole_; }
  /// Whether the rendered image must be warped.
  bool warps() const { return warps_; }
  /// CV_32FC2: (X/Z, Y/Z) of the ray through each pixel centre of the camera.
  const cv::Mat& rays() const { return rays_; }

  /// CV_32FC2: where each pixel lies in the ideal camera's picture, px. Empty unless the lens warps.
  const cv::Mat& map() const { return map_; }

  /// Depth as this camera sees it, CV_32FC1, m; 0 where nothing is. 1/z is interpolated, which is exact on planes;
  /// across an edge the nearest sample is taken.
  /// @param nearness 1/z as the ideal camera sees it (Renderer::ReadNearness).
  cv::Mat Depth(const cv::Mat& nearness) const;
  /// The same from a picture of another raster: `picture` is an ideal camera at the same place with square pixels,
  /// whose picture covers all rays and a pixel more on each side.
  cv::Mat Depth(const cv::Mat& nearness, const CameraModel& picture) const;
  /// Labels: the nearest sample.
  cv::Mat WarpLabels(const cv::Mat& labels) const;

 private:
  CameraModel camera_, pinhole_;
  bool warps_ = false;
  cv::Mat rays_;
  cv::Mat map_;
};

}  // namespace gaitcam
