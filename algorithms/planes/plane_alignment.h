/// Where a camera has moved over a plane, from the pixels themselves: Efficient Second-order Minimisation (ESM) over a
/// rigid motion and the plane's scaled normal, thesis 6.4.1, Eqs. 6.3 to 6.19.
///
/// Frames: R is the camera at the reference image, C at the current one. A point p of the plane (in R) satisfies
/// n_d . p = 1, n_d being the plane's normal over its distance; it is seen in C at X_CR p, which makes the homography
/// H = R + t n_d' of Eq. 6.3 between normalised coordinates. n_d is carried by the inverse depths of three image points
/// and their logarithms (Eqs. 6.12 to 6.16), which keeps the plane before the camera.
///
/// Beyond the thesis: a pyramid; Huber weights; gain and offset of brightness; what is known beforehand of the plane
/// and of the motion (without it, t and n_d have one common scale too many, and a small t leaves the normal to the
/// noise); motion blur as a part of the image formation.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"
#include "algorithms/planes/image_pyramid.h"

namespace gaitcam {

/// Rigid motion near the identity as (translation, rotation vector); Eq. 6.11 and its inverse.
using Vector6d = Eigen::Matrix<double, 6, 1>;
Pose ExpSe3(const Vector6d& x);
Vector6d LogSe3(const Pose& X);

/// What is estimated.
struct PlaneState {
  Pose X_CR;                                            ///< T of Eq. 6.6.
  Eigen::Vector3d normal_d = Eigen::Vector3d(0, 0, 1);  ///< n_d of Eq. 6.3, in R, 1/m.
  double gain = 1, offset = 0;                          ///< current = gain reference + offset.
};

/// What is known beforehand, as Gaussians about the state that the alignment starts from.
struct PlanePrior {
  double distance_sigma = 0.01;      ///< Of the plane's distance, relative. Fixes the common scale.
  double tilt_sigma_rad = 0.05;      ///< Of its normal, about each axis.
  double translation_sigma_m = 1e3;  ///< Of X_CR, per axis.
  double rotation_sigma_rad = 1e3;
};

struct PlaneAlignmentOptions {
  using DescribedTag = void;
  int levels = 4;                   ///< Of the pyramid, coarse to fine.
  int max_points = 1500;            ///< Pixels per level: those of largest gradient, well spread.
  int max_iterations = 20;          ///< Per level.
  double step_px = 0.01;            ///< A level is done when a step moves its pixels by less (root mean square).
  double huber = 1.345;             ///< In standard deviations of the residuals: beyond it they weigh less.
  double noise_grey = 2.0;          ///< Least standard deviation that is assumed of a pixel.
  double min_inside_ratio = 0.3;    ///< A smaller part of the points inside the current image: diverged.
  double max_residual_grey = 40.0;  ///< A larger robust standard deviation of the residuals: diverged.
  bool photometric = true;          ///< Estimate gain and offset.
  int max_blur_samples = 9;         ///< Sub-poses of an exposure; 1 takes both images for sharp.
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

/// How still points moved in a camera's frame while its shutter was open: (translation, rotation vector).
using ExposureMotion = Vector6d;

/// How the current image is blurred, as far as it is known before its pose is.
struct CurrentBlur {
  double ratio = 0;                     ///< Exposure over the time since the frame before it; 0: it is sharp.
  Pose X_RP;                            ///< Where that frame was, in R: at R itself if it was the reference.
  std::optional<Eigen::Vector3d> turn;  ///< Of the camera in its own frame during the exposure (rotation vector),
                                        ///< where a gyroscope tells it; without, the motion since P goes on.

  CurrentBlur(double ratio = 0) : ratio(ratio) {}  // NOLINT: a ratio alone is the common case
  ExposureMotion Motion(const Pose& X_CR) const;
};

/// The reference image and those of its pixels that lie on the plane.
struct PlaneReference {
  ImagePyramid pyramid;
  std::vector<std::vector<Eigen::Vector2d>> points;  ///< Per level, px of that level.
  ExposureMotion blur = ExposureMotion::Zero();      ///< Of the reference image.
};

struct PlaneAlignment {
  PlaneState state;
  bool converged = false;    ///< False: `state` is where it was given up.
  int iterations = 0;        ///< Over all levels.
  double residual_grey = 0;  ///< Robust standard deviation at the finest level.
  double inside_ratio = 0;   ///< Part of the points that fell inside the current image.
  int inliers = 0;           ///< Those of them within three standard deviations.
  double correlation = 0;    ///< Of what both images show at those points, -1..1.
  Eigen::Matrix<double, 6, 6> motion_covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< Of x in X_CR exp(x).
  Eigen::Matrix3d normal_covariance = Eigen::Matrix3d::Zero();                          ///< Of n_d.
};

class PlaneAligner {
 public:
  /// @param camera of undistorted images. @throws BadOption.
  PlaneAligner(const CameraModel& camera, const PlaneAlignmentOptions& options);

  /// @param mask CV_8UC1 of the image's size: not zero where the plane is seen. Keeps pixels of large gradient.
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

/// Where a pixel of R is seen in C (Eq. 6.7), px; nothing if it falls behind the camera.
std::optional<Eigen::Vector2d> WarpPixel(const CameraModel& camera, const PlaneState& state,
                                         const Eigen::Vector2d& p_R);

namespace internal {

/// M of Eq. 6.15 for normalised coordinates of three points: n_d = M z. Columns: the points' share.
Eigen::Matrix3d NormalFromInverseDepths(const std::vector<Eigen::Vector3d>& rays);

/// Derivative of the warped pixel (in C, px) by motion and log inverse depths, at zero increments.
/// @param level_scale 2^level: focal lengths are divided by it.
Eigen::Matrix<double, 2, 9> WarpJacobian(const CameraModel& camera, double level_scale, const PlaneState& state,
                                         const Eigen::Matrix3d& M, const Eigen::Vector2d& p_R);

}  // namespace internal
}  // namespace gaitcam
