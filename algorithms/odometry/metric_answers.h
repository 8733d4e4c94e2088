/// An odometry's answers in metres, for a camera whose standing height over the floor is known: what metric_scale.h
/// knows of a map's unit, applied to the poses as they are handed over.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/up_direction.h"
#include "algorithms/odometry/metric_scale.h"

namespace gaitcam {

class MetricAnswers {
 public:
  /// @param calibration has `standing`.
  explicit MetricAnswers(const Calibration& calibration);

  /// Readings up to the present frame, before anything else is said of it.
  void Add(const std::vector<ImuSample>& imu) { up_C_.Add(imu); }
  /// The vertical in the present frame, a unit vector.
  Eigen::Vector3d up_C() const { return up_C_.up_C(); }
  /// Where the camera was on average lately, in W and in the map's unit.
  const Carried& carried() const { return carried_.mean(); }

  /// The present frame has a pose. In W the vertical stands still, but for the drift of the poses' rotations.
  void Follow(const Pose& X_WC, int64_t stamp_ns);

  /// To be called once for every keyframe, in order: the first one of a map, any later one.
  void BeginMap() { scale_.Add({}, true); }
  std::optional<CarriedHeight> AddKeyframe(const KeyframeMap& map);
  void GiveUpMap();

  /// The answer to the present frame, its pose or prediction in metres. A map whose unit is not known yet is still
  /// being started, for two seconds: with no floor in view it never will be, and poses are handed over in any unit
  /// then.
  FrameEstimate InMetres(FrameEstimate answer, bool has_map);

  /// For each keyframe, metres per unit by all that is known in the end.
  std::vector<double> Smoothed() const { return scale_.Smoothed(); }

 private:
  Pose InMetres(const Pose& X_WC) const;

  UpDirection up_C_;
  CarriedMean carried_;
  MetricScale scale_;

  double factor_ = 1;                     ///< By which the last pose's motion was multiplied.
  bool is_known_ = false;                 ///< It was measured, in the present map.
  std::optional<int64_t> held_since_ns_;  ///< The first frame of the present map whose pose was not handed over.
  bool out_of_patience_ = false;          ///< Poses are handed over whatever their unit.
  bool restarts_ = false;                 ///< One of those that were held back began the map.
  /// The last position handed over, in the map's unit and in metres.
  Eigen::Vector3d at_ = Eigen::Vector3d::Zero(), at_m_ = Eigen::Vector3d::Zero();
};

}  // namespace gaitcam
