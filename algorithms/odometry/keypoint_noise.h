/// How exactly a detector locates a key point in an image that may be blurred: a covariance per key point.
///
/// The variance of a position is the sum of what a sharp image leaves, of what grows with the key point's scale, of
/// what the sensor's noise does to its contrast, and of a share of the blur: more along the motion, where the image has
/// lost its detail, than across.
///
/// The defaults are those of SIFT, calibrated on `hall`, which no suite films: recordings by
///   gaitcam record scenarios/stereo_walk.yaml --format euroc --truth-inside --set scene=hall --set duration_s=6
/// at 640 x 480 (seed 1) and 320 x 240 (seed 101, variation=repeat; gaits slow, normal, brisk; 5 to 33 ms), by what
/// residuals and normalised errors (nees_1f, nees_1s) of poses were at blurs of 0 to 22 px. `sigma_per_noise` is not
/// calibrated: it is 1, which the bound itself says. `hidden_per_blur` and the two numbers of points per error are of
/// later recordings of the same scene, scenarios/studies/stereo_noise.yaml.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

struct KeypointNoiseOptions {
  using DescribedTag = void;

  double sigma_px = 0.1;             ///< Standard deviation of each coordinate, px, of the smallest key point ...
  double sigma_per_size = 0.02;      ///< ... what each px of a key point's diameter makes of it ...
  double sigma_per_blur = 0.08;      ///< ... each px of blur along the motion ...
  double sigma_across_blur = 0.035;  ///< ... and across it.
  double sigma_per_noise = 1;        ///< Of the least standard deviation that the image's noise allows (NoiseBound).
  /// What all key points of a frame have in common, as if it had turned: part of its turn over the exposure.
  double common_per_blur = 0.02;
  /// Errors of key points hang together where they lie near each other, and what a sharp image leaves of a landmark
  /// repeats from keyframe to keyframe: so many count as one in what keyframes add ...
  double points_per_error = 25;
  double points_per_blur_error = 1;  ///< ... and so many of those that blur and noise make anew in each image.
  /// A pose's own covariance is that of its residuals, which have the errors of its landmarks in them, too, by ...
  double residuals_share = 0.7;
  double hidden_per_blur = 0.08;  ///< ... plus so much with each px of blur: what a fit hides, being common to all.
  double offset_scale = 0.55;     ///< Of the smoothing in BlurOffset, in diameters of the key point.
};

template <class Visitor>
void VisitFields(Visitor& visit, KeypointNoiseOptions& o) {
  visit("sigma_px", o.sigma_px, Between(0.001, 100.0), "standard deviation of the smallest key point's position, px");
  visit("sigma_per_size", o.sigma_per_size, Between(0.0, 10.0), "what each px of a key point's diameter makes of it");
  visit("sigma_per_blur", o.sigma_per_blur, Between(0.0, 10.0), "each px of blur, along the motion");
  visit("sigma_across_blur", o.sigma_across_blur, Between(0.0, 10.0), "each px of blur, across the motion");
  visit("sigma_per_noise", o.sigma_per_noise, Between(0.0, 100.0),
        "standard deviation by the image's noise over the least that is possible");
  visit("common_per_blur", o.common_per_blur, Between(0.0, 10.0),
        "each px of blur, along the motion, of all key points of a frame alike");
  visit("points_per_error", o.points_per_error, Between(1.0, 1e4),
        "key points whose errors hang together so that they count as one in what keyframes add");
  visit("residuals_share", o.residuals_share, Between(0.01, 100.0),
        "a sharp frame's own covariance over that of its residuals, which show its landmarks' errors, too");
  visit("points_per_blur_error", o.points_per_blur_error, Between(1.0, 1e4), "the same of errors by blur and noise");
  visit("hidden_per_blur", o.hidden_per_blur, Between(0.0, 100.0), "and so much more with each px of blur");
  visit("offset_scale", o.offset_scale, Between(0.1, 10.0),
        "a blurred point is seen where its light, smoothed so, peaks");
}

/// How the light of one point was spread: the covariance, px^2, of where its image was while the shutter was open. Of a
/// uniform straight motion by b px it is b^2 / 12 along it.
/// @param path of this camera over the exposure, at equally spaced instants: each maps points of the camera at
/// mid-exposure into the camera then
/// @param pixel where the point was at mid-exposure
/// @param inverse_depth of the point, 1/m; 0: so far that only turns move its image
Eigen::Matrix2d BlurSpread(const CameraModel& camera, const std::vector<Pose>& path, const Eigen::Vector2d& pixel,
                           double inverse_depth);

/// Where a detector sees a point whose image moved, against where it was at mid-exposure, px. A blob filter of the key
/// point's scale answers most where the light, smoothed by that scale, is densest: for a coarse key point that is the
/// path's mean, for a fine one where the image lingered.
/// @param path, inverse_depth as of BlurSpread
/// @param pixel near where it was at mid-exposure
/// @param sigma_px scale of the key point
Eigen::Vector2d BlurOffset(const CameraModel& camera, const std::vector<Pose>& path, const Eigen::Vector2d& pixel,
                           double inverse_depth, double sigma_px);

/// Where a rolling shutter saw a point against where it was at the frame's stamp, px.
/// @param readout of this camera when rows were exposed, evenly spaced from the first to the last: each maps points of
/// the camera at the stamp into the camera then. Empty: nothing rolls
/// @param seen in the image
/// @param inverse_depth as of BlurSpread
Eigen::Vector2d RowOffset(const CameraModel& camera, const std::vector<Pose>& readout, const Eigen::Vector2d& seen,
                          double inverse_depth);

/// Standard deviation of an image's noise, in grey levels, by what a difference of Laplacians leaves of the scene
/// (J. Immerkaer, "Fast noise variance estimation", CVIU 64, 1996); fine texture counts as noise. 0 below 3 x 3 px.
double ImageNoise(const cv::Mat& grey);

/// The least covariance, px^2, that noise allows for a key point's position (Cramer and Rao): noise^2 over the sum of
/// squared gradients over the key point's area, less what noise adds to these. Where noise is all that there is it is
/// bounded, by that of a gradient well below the noise.
/// @param noise as of ImageNoise; 0 gives 0
Eigen::Matrix2d NoiseBound(const cv::Mat& grey, const cv::KeyPoint& keypoint, double noise);

/// px^2, of the key point's position.
/// @param spread as of BlurSpread
/// @param bound as of NoiseBound
Eigen::Matrix2d KeypointCovariance(const cv::KeyPoint& keypoint, const Eigen::Matrix2d& spread,
                                   const Eigen::Matrix2d& bound, const KeypointNoiseOptions& options);

/// How many of an image's key points count as one in what keyframes add: between points_per_blur_error and
/// points_per_error, by how much of their variance a sharp image would have, too.
/// @param covariances_px of each key point, as of KeypointCovariance
double PointsPerError(const std::vector<cv::KeyPoint>& keypoints, const std::vector<Eigen::Matrix2d>& covariances_px,
                      const KeypointNoiseOptions& options);

}  // namespace gaitcam
