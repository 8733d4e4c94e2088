/// How the camera moved between two instants by the body's own odometry, its wheels or legs. A body that rocks as it
/// goes has its gyroscope tell how the camera turned, where that knows it better.

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/gyro_turn.h"

namespace gaitcam {

class BodyTrack {
 public:
  /// @param imu its gyroscope is used; a rate of 0: none is.
  explicit BodyTrack(const OdometryCalibration& calibration, const ImuCalibration& imu = {});

  /// The next samples, in time order.
  void Add(const std::vector<OdometrySample>& samples, const std::vector<ImuSample>& imu = {});
  /// Forgets what lies before an instant, but for the sample that it needs itself.
  void Forget(int64_t before_ns);

  /// Of the camera, the body's height and tilt taken as those of X_BC but for its rocking. Between samples the body
  /// moves evenly, and a little beyond the last one as it did before. @returns nothing if the samples do not reach both
  /// instants.
  std::optional<RelativePose> Between(int64_t from_ns, int64_t to_ns) const;

 private:
  void TurnByGyroscope(RelativePose& moved) const;
  std::optional<PlanarPose> At(int64_t stamp_ns) const;

  OdometryCalibration calibration_;
  std::deque<OdometrySample> samples_;
  std::optional<GyroTurn> gyro_;
};

}  // namespace gaitcam
