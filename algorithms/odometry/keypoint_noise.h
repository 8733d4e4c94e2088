/// How exactly a detector locates a key point in an image that may be blurred: a covariance per key point.
///
/// The variance of a position is the sum of what a sharp image leaves, of what grows with the key point's scale, and of
/// a share of the blur: more along the motion, where the image has lost its detail, than across.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/features/psf_inertial.h"

namespace gaitcam {

struct KeypointNoiseOptions {
  using DescribedTag = void;

  double sigma_px = 0.2;           ///< Standard deviation of each coordinate, px, of the smallest key point ...
  double sigma_per_size = 0.04;    ///< ... what each px of a key point's diameter makes of it ...
  double sigma_per_blur = 0.05;    ///< ... each px of blur along the motion ...
  double sigma_across_blur = 0.0;  ///< ... and across it.
};

template <class Visitor>
void VisitFields(Visitor& visit, KeypointNoiseOptions& o) {
  visit("sigma_px", o.sigma_px, Between(0.001, 100.0), "standard deviation of the smallest key point's position, px");
  visit("sigma_per_size", o.sigma_per_size, Between(0.0, 10.0), "what each px of a key point's diameter makes of it");
  visit("sigma_per_blur", o.sigma_per_blur, Between(0.0, 10.0), "each px of blur, along the motion");
  visit("sigma_across_blur", o.sigma_across_blur, Between(0.0, 10.0), "each px of blur, across the motion");
}

/// How the light of one point was spread: the covariance, px^2, of where its image was while the shutter was open. Of a
/// uniform straight motion by b px it is b^2 / 12 along it.
/// @param rotations of this camera over the exposure
/// @param pixel where it was at mid-exposure
Eigen::Matrix2d BlurSpread(const CameraModel& camera, const std::vector<ExposureRotation>& rotations,
                           const Eigen::Vector2d& pixel);

/// px^2, of the key point's position.
/// @param spread as of BlurSpread
Eigen::Matrix2d KeypointCovariance(const cv::KeyPoint& keypoint, const Eigen::Matrix2d& spread,
                                   const KeypointNoiseOptions& options);

}  // namespace gaitcam
