/// A frame's features and what they mean geometrically.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "algorithms/features/features.h"

namespace gaitcam {

struct FrameView {
  Features features;
  std::vector<Eigen::Vector2d> xy;  ///< Undistorted normalised coordinates, one per feature.
  std::vector<double> sigma;        ///< Standard deviation of each coordinate.
  Pose X_WC;
};

/// How exactly a feature's place is known.
struct FeatureNoise {
  double sigma_px = 0;        ///< Standard deviation of each coordinate of the smallest feature ...
  double sigma_per_size = 0;  ///< ... and what each px of a keypoint's diameter adds to it.
};

/// @throws BadInput if the image's size is not the camera's
FrameView ViewFrame(const cv::Mat& image, const CameraModel& camera, cv::Feature2D& detector, int max_features,
                    const FeatureNoise& noise);

}  // namespace gaitcam
