/// Blur from the angular rates that the gyroscope measured while the shutter was open; the image is not used.
///
/// Assumes that the camera only turns: a translation of t metres adds f t / depth pixels, which at 20 ms, 0.2 m/s and
/// 1 m is a tenth of what 1 rad/s of rotation does. Also that the IMU is fixed to the camera: the rate of a neck
/// joint between them would be missing.

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/psf.h"

namespace gaitcam {

/// Orientation of the camera at an instant of the exposure: rotation maps directions in the camera at mid-exposure
/// into the camera at `stamp_ns`.
struct ExposureRotation {
  int64_t stamp_ns = 0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

/// Integrates angular rates over an exposure. A reading holds for the time that is nearer to it than to the others; the
/// first and the last reading hold beyond their stamps.
/// @param imu readings in time order, in the IMU's frame; those of the exposure and, if there are, one before and
/// after.
/// @param open_ns, close_ns the shutter's.
/// @param steps instants, equally spaced from open to close; at least 2.
/// @throws BadInput if there is no reading or the shutter closes before it opens.
std::vector<ExposureRotation> IntegrateRotation(const std::vector<ImuSample>& imu, const ImuCalibration& calibration,
                                                int64_t open_ns, int64_t close_ns, int steps = 17);

class InertialPsf : public PsfEstimator {
 public:
  /// @param gyro_bias rad/s, taken from each reading; the IMU's frame.
  /// @throws BadInput as IntegrateRotation; BadOption if the camera is not possible.
  InertialPsf(const std::vector<ImuSample>& imu, const ImuCalibration& calibration, const CameraModel& camera,
              int64_t open_ns, int64_t close_ns, const Eigen::Vector3d& gyro_bias = Eigen::Vector3d::Zero(),
              double verdict_px = 3);

  /// Where the point that lies at `pixel` at mid-exposure was at each instant of rotations(), px.
  std::vector<Eigen::Vector2d> Path(const Eigen::Vector2d& pixel) const;
  /// From its first to its last position.
  Eigen::Vector2d BlurVector(const Eigen::Vector2d& pixel) const;
  LineBlur At(const Eigen::Vector2d& pixel) const { return LineBlur::FromVector(BlurVector(pixel)); }
  /// The image's parts with the paths that their light took, for BlurAwareFeature::SetBlurRegions: what is restored
  /// then shows where things were at mid-exposure. A part that was not always in view is called sharp.
  std::vector<BlurRegion> Regions() const;
  const std::vector<ExposureRotation>& rotations() const { return rotations_; }

  /// The mean of the blurs over a grid of the region (MeanBlur). Confidence is the path's straightness there: net
  /// displacement over path length, 0 for a camera that returned to where it was.
  BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const override;

 private:
  CameraModel camera_;
  std::vector<ExposureRotation> rotations_;
  double verdict_px_;
};

}  // namespace gaitcam
