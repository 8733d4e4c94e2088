/// Keyframes over the floor: the one that frames are aligned with, and what remains of it once another succeeds it.
///
/// World W: z = 0 is the floor, z up.

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "algorithms/planes/floor_regions.h"
#include "algorithms/planes/plane_alignment.h"

namespace gaitcam {

/// A retired keyframe: which parts of it show floor is known now.
struct FloorKeyframe {
  int id = 0;
  int64_t stamp_ns = 0;
  ImagePyramid image;  ///< Undistorted display values, not smoothed.
  cv::Mat floor;       ///< CV_8UC1: not zero where it shows floor.
  Pose X_WK;
  /// Of the position (m) and yaw (rad) of the frame below the camera, in itself, since the keyframe before.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<FloorRegion> regions;

  /// Floor's share in the area of the textured regions that were judged; 1 if none was.
  double FloorRatio() const;
};

/// The keyframe that frames are aligned with.
struct FloorReference {
  int id = 0;
  int64_t stamp_ns = 0;
  cv::Mat grey;  ///< Undistorted display values.
  cv::Mat mask;  ///< CV_8UC1: not zero where it is compared.
  PlaneReference pixels;
  std::vector<PutativePlane> regions;
  PlaneState plane;  ///< Its normal.
  Pose X_WK;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< As FloorKeyframe's.
  int aligned_frames = 0;                                ///< Aligned with it, in all.
  int missed_frames = 0;                                 ///< Not aligned with it, in a row, up to the last frame.
  /// R_KC of the last frame by the gyroscope, and the time that it was integrated over; nothing where samples lacked.
  std::optional<Eigen::Quaterniond> R_KC_gyro = Eigen::Quaterniond::Identity();
  double gyro_s = 0;

  /// What is known without judging its regions.
  FloorKeyframe Retired() const;
};

/// The floor's plane in a camera's frame; X_CR is the identity.
PlaneState FloorPlaneState(const Pose& X_WC);

/// The pose `height` above the same point of the floor, turned by the smallest rotation that makes `up_C` vertical.
Pose Upright(const Pose& X_WC, const Eigen::Vector3d& up_C, double height);

/// CV_8UC1: 255 where pixels would show floor nearer than `range_heights` camera heights if nothing stood on it.
cv::Mat FloorMask(const CameraModel& camera, const Pose& X_WC, double range_heights);

/// The keyframe as retired by a later image, against which its regions are judged (floor_regions.h).
/// @param now motion and plane by which that image is aligned with it.
FloorKeyframe Retire(const FloorReference& reference, const PlaneAligner& aligner, const CameraModel& camera,
                     const ImagePyramid& image, const PlaneState& now, const CurrentBlur& blur,
                     const FloorRegionOptions& options);

/// Where the regions of a keyframe that are no floor appear in a later image, roughly: warped as if they lay on the
/// floor, plus a margin. CV_8UC1; empty if there are none.
cv::Mat WarpRejected(const FloorKeyframe& retired, const CameraModel& camera, const PlaneState& now);

}  // namespace gaitcam
