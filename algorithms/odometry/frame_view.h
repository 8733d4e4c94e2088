/// A frame's features and their rays.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"
#include "algorithms/features/features.h"

namespace gaitcam {

struct FrameView {
  Features features;
  std::vector<Eigen::Vector2d> xy;  ///< Undistorted normalised image coordinates, one per feature.
  std::vector<double> sigma;        ///< Standard deviation of each coordinate.
  Pose X_WC;                        ///< Set once it is estimated.
};

/// How exactly a feature is located: standard deviation of each pixel coordinate, px.
struct FeatureNoise {
  double sigma_px = 0;        ///< Of a keypoint of size 0.
  double sigma_per_size = 0;  ///< What each px of a keypoint's diameter adds.
};

/// @throws BadInput if the image's size is not the camera's
void CheckImageSize(const cv::Mat& image, const CameraModel& camera);

/// Detects, describes and undistorts.
/// @throws BadInput if the image's size is not the camera's
FrameView ViewFrame(const cv::Mat& image, const CameraModel& camera, cv::Feature2D& detector, int max_features,
                    const FeatureNoise& noise);

/// Names of all detectors (algorithms/features/features.h), for options.
Words FeatureNames();

}  // namespace gaitcam
