/// Direct alignment of a plane: a camera's motion over it by Efficient Second-order Minimisation (ESM) of intensity
/// differences over a rigid motion and the plane's scaled normal, thesis 6.4.1, Eqs. 6.3 to 6.19. Frames and equations:
/// plane_warp.h, plane_residuals.h.
///
/// Beyond the thesis: an image pyramid; Huber weights; gain and offset of brightness; priors of the plane and of the
/// motion (without them the common scale of t and 1 / n_d is not observable, and a small t leaves the normal to the
/// noise); motion blur as a part of the image formation.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/se3.h"
#include "algorithms/planes/image_pyramid.h"
#include "algorithms/planes/plane_reference.h"
#include "algorithms/planes/plane_residuals.h"
#include "algorithms/planes/plane_warp.h"

namespace gaitcam {

/// Gaussian priors about the state that the alignment starts from.
struct PlanePrior {
  double distance_sigma = 0.01;      ///< Of the plane's distance, relative. Fixes the scale.
  double tilt_sigma_rad = 0.05;      ///< Of its normal, about each axis.
  double translation_sigma_m = 1e3;  ///< Of X_CR, per axis.
  double rotation_sigma_rad = 1e3;
};

struct PlaneAlignmentOptions {
  using DescribedTag = void;
  int levels = 4;                   ///< Of the pyramid, coarse to fine.
  int max_points = 1500;            ///< Pixels per level, see SelectPixels.
  int max_iterations = 20;          ///< Per level.
  double step_px = 0.01;            ///< A smaller step, by the root mean square over pixels, ends a level.
  double huber = 1.345;             ///< Threshold of Huber's weights, in standard deviations.
  double noise_grey = 2.0;          ///< Lower bound of the residuals' standard deviation.
  double min_inside_ratio = 0.3;    ///< Part of the points inside the current image; less: diverged.
  double max_residual_grey = 40.0;  ///< Robust standard deviation of the residuals; more: diverged.
  bool photometric = true;          ///< Estimate gain and offset.
  int max_blur_samples = 9;         ///< Samples along an exposure's path; 1: no blur.
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaneAlignmentOptions& o) {
  visit("levels", o.levels, Between(1, 8), "pyramid levels");
  visit("max_points", o.max_points, Between(50, 1000000), "pixels per level: those of largest gradient, well spread");
  visit("max_iterations", o.max_iterations, Between(1, 1000), "per level");
  visit("step_px", o.step_px, Between(1e-6, 1.0), "a smaller step ends a level");
  visit("huber", o.huber, Between(0.1, 100.0), "standard deviations beyond which a residual weighs less");
  visit("noise_grey", o.noise_grey, Between(0.01, 100.0), "least standard deviation of a pixel");
  visit("min_inside_ratio", o.min_inside_ratio, Between(0.0, 1.0), "fewer points inside the image: diverged");
  visit("max_residual_grey", o.max_residual_grey, Between(0.1, 255.0), "larger residuals: diverged");
  visit("photometric", o.photometric, Nested(), "estimate gain and offset");
  visit("max_blur_samples", o.max_blur_samples, Between(1, 99), "sub-poses of an exposure; 1: none");
}

struct PlaneAlignment {
  PlaneState state;
  bool converged = false;                                       ///< False: `state` is the last iterate.
  int iterations = 0;                                           ///< Over all levels.
  double residual_grey = 0;                                     ///< Robust standard deviation at the finest level.
  double inside_ratio = 0;                                      ///< Part of the points inside the current image.
  int inliers = 0;                                              ///< Of these, residuals within 3 standard deviations.
  double correlation = 0;                                       ///< Of the two images at these points, -1..1.
  Matrix6d motion_covariance = Matrix6d::Zero();                ///< Of X_CR, in the tangent of se3.h.
  Eigen::Matrix3d normal_covariance = Eigen::Matrix3d::Zero();  ///< Of n_d.
};

class PlaneAligner {
 public:
  /// @param camera of undistorted images. @throws BadOption.
  PlaneAligner(const CameraModel& camera, const PlaneAlignmentOptions& options);

  /// @param mask CV_8UC1 of the image's size: not zero where the plane is seen.
  PlaneReference MakeReference(const cv::Mat& image, const cv::Mat& mask) const;
  ImagePyramid MakePyramid(const cv::Mat& image) const { return ImagePyramid::Of(image, options_.levels); }

  /// @param blur of the current image; it depends on the motion that is estimated.
  PlaneAlignment Align(const PlaneReference& reference, const ImagePyramid& current, const PlaneState& guess,
                       const PlanePrior& prior, const CurrentBlur& blur = {}) const;

  const PlaneAlignmentOptions& options() const { return options_; }

 private:
  CameraModel camera_;
  PlaneAlignmentOptions options_;
};

}  // namespace gaitcam
