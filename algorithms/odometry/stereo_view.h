/// A frame of a stereo rig: the features of both images, their rays, how exactly each is known, and which are images of
/// the same point.

#pragma once

#include <Eigen/Core>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/features.h"
#include "algorithms/geometry/rig_pose.h"
#include "algorithms/geometry/stereo_reconstruction.h"
#include "algorithms/odometry/keypoint_noise.h"

namespace gaitcam {

struct StereoMatchingOptions {
  using DescribedTag = void;

  double stereo_ratio = 0.85;      ///< Nearest over second nearest descriptor distance along an epipolar line.
  double epipolar_px = 2.0;        ///< Largest distance from the epipolar line ...
  double epipolar_sigmas = 3.0;    ///< ... to which so many standard deviations of the features are added.
  double least_distance_m = 0.15;  ///< Nothing is nearer to the rig: sets the largest disparity.
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoMatchingOptions& o) {
  visit("stereo_ratio", o.stereo_ratio, Between(0.1, 1.0), "ratio test between candidates along an epipolar line");
  visit("epipolar_px", o.epipolar_px, Between(0.1, 100.0), "largest distance from the epipolar line, px");
  visit("epipolar_sigmas", o.epipolar_sigmas, Between(0.0, 100.0), "standard deviations that are added to it");
  visit("least_distance_m", o.least_distance_m, Between(0.001, 100.0), "nothing is nearer to the rig");
}

/// Features of one image.
struct CameraFeatures {
  Features features;                           ///< One per place and scale: what has several orientations is one.
  std::vector<Eigen::Vector2d> pixel;          ///< Of the key point, at mid-exposure ...
  std::vector<Eigen::Vector2d> xy;             ///< ... and in normalised coordinates, distortion undone.
  std::vector<Eigen::Matrix2d> noise_px;       ///< What the image's noise leaves of it, px^2 (NoiseBound).
  std::vector<Eigen::Matrix2d> covariance_px;  ///< Of the pixel, px^2 ...
  std::vector<Eigen::Matrix2d> covariance;     ///< ... and of xy.

  size_t size() const { return xy.size(); }
};

/// How a camera moved while an image was taken.
struct ImageMotion {
  /// Over the exposure of rows evenly spaced from the first to the last, as of BlurSpread: poses map points of the
  /// camera at that row's mid-exposure. One: of all rows; none: as if nothing had moved.
  std::vector<std::vector<Pose>> exposures;
  /// When rows were exposed, as of RowOffset: poses map points of the camera at mid-exposure of the row in the middle,
  /// which is the frame's stamp. Empty: all at once.
  std::vector<Pose> readout;

  /// Of the row at this height.
  const std::vector<Pose>& ExposureAt(const CameraModel& camera, double y_px) const;
  /// Of a camera fixed to this one, X_(this)(other).
  ImageMotion Of(const Pose& X_TO) const;
};

struct StereoView {
  CameraFeatures left, right;
  std::vector<int> partner;     ///< Of each left feature the right one; -1: none.
  double points_per_error = 1;  ///< So many left features count as one in what keyframes add (PointsPerError).

  /// Of a left feature that has a partner, in pixels.
  StereoSighting Sighting(size_t i) const;
  /// Of a left feature as the image of a point (m, m^2), in normalised coordinates; with the right one if it has a
  /// partner.
  RigSighting SightingOf(size_t i, const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance_W) const;
  /// Of all left features that have a partner.
  std::vector<StereoSighting> Sightings() const;
};

/// Detects, describes and undistorts.
/// @throws BadInput if the image's size is not the camera's; `which` names it.
CameraFeatures DetectInCamera(const cv::Mat& image, const CameraModel& camera, const std::string& which,
                              cv::Feature2D& detector, int max_features);

/// Whether a frame has both images, of one instant (within 1 ms).
/// @throws BadInput saying what is wrong instead, if it is the first frame: then it is the rig that is wrong, or its
/// files, and not a moment.
bool IsPair(const Observation& observation, bool is_first);

/// Both images' features; partners are not looked for. @pre IsPair. @throws BadInput as DetectInCamera.
StereoView DetectInBoth(const Observation& observation, const StereoRig& rig, cv::Feature2D& detector,
                        int max_features);

/// @throws BadInput if left and right images are swapped, as their matches by descriptors alone tell. @pre UndoMotion.
void RefuseSwapped(const StereoRig& rig, const StereoView& view);

/// Moves each feature to where its point was at mid-exposure of the row in the middle, and says how exactly it is
/// known. May be repeated.
/// @param inverse_depths of each feature, 1/m; empty: all far
void UndoMotion(const CameraModel& camera, const ImageMotion& motion, const std::vector<double>& inverse_depths,
                const KeypointNoiseOptions& noise, CameraFeatures& features);

/// Of each left feature, 1/m: by its partner, or that of the nearest feature in the image that has one. Empty where
/// none has.
std::vector<double> InverseDepths(const StereoRig& rig, const StereoView& view);

/// Pairs left and right features along epipolar lines, each other's nearest by descriptors.
std::vector<int> MatchStereo(const StereoRig& rig, const CameraFeatures& left, const CameraFeatures& right,
                             const StereoMatchingOptions& options);

}  // namespace gaitcam
