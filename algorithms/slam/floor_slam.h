/// Monocular SLAM over a flat floor from the homographies of the floor plane, with an intensity map of it (thesis,
/// chapter 6): a tracker aligns each frame with a keyframe; a Rao-Blackwellised particle filter maps the keyframes and
/// closes loops where the camera returns to mapped floor.

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/planes/floor_filter.h"
#include "algorithms/planes/floor_tracker.h"

namespace gaitcam {

struct FloorSlamOptions {
  using DescribedTag = void;
  FloorTrackerOptions tracker;
  FloorFilterOptions filter;
  bool use_map = true;  ///< False: dead reckoning by the tracker; the map is drawn but closes no loop.
  /// How well the camera's height is known, relative, beside what the calibration says of its own error
  /// (StandingCamera::height_sigma): it is the scale of all, so ways are known no better.
  double height_sigma_ratio = 0.003;
  /// How well the vertical is known, about each horizontal axis, beside StandingCamera::pitch_sigma.
  double tilt_sigma_deg = 0.1;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorSlamOptions& o) {
  visit("tracker", o.tracker, Nested(), "frame by frame");
  visit("filter", o.filter, Nested(), "map and trajectory");
  visit("use_map", o.use_map, Nested(), "false: tracking alone, the map corrects nothing");
  visit("height_sigma_ratio", o.height_sigma_ratio, Between(1e-6, 1.0),
        "standard deviation of the standing height and so of the scale, beside the calibration's own, for the "
        "covariance");
  visit("tilt_sigma_deg", o.tilt_sigma_deg, Between(1e-4, 90.0),
        "standard deviation of the vertical, beside the calibration's own, for the covariance");
}

class FloorSlam {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands.
  FloorSlam(const Calibration& calibration, const FloorSlamOptions& options, uint64_t seed);

  /// World W: z = 0 is the floor, z up, the origin below the first camera, x along its view; metres.
  ///
  /// Covariances are of the pose in W, so relative to where the first camera stood: position in the floor and heading
  /// by the particles' spread (of Finish(): by the pose graph), what was tracked since the last keyframe, and the
  /// scale; height and tilt as the options have them, tilt worse for some seconds after a loss. While a submap hangs
  /// loose they say so. There is none with `use_map: false`: no particles, no spread.
  FrameEstimate Track(const Observation& observation);
  /// Every frame on the smoothed trajectory, corrections interpolated between keyframes.
  std::vector<FrameEstimate> Finish();
  FloorPicture Floor() const { return filter_.Map(filter_.SmoothPath()); }

  const FloorFilter& filter() const { return filter_; }
  const std::vector<int64_t>& keyframe_stamps() const { return keyframe_ns_; }

 private:
  struct Record {
    FrameEstimate estimate;
    Pose X_tracked;                                            ///< By the tracker.
    bool aligned = false;                                      ///< With a keyframe ...
    int keyframe = 0;                                          ///< ... of this FloorKeyframe::id.
    Eigen::Matrix3d since_keyframe = Eigen::Matrix3d::Zero();  ///< FloorTrack::covariance.
    double since_loss_s = 0;                                   ///< Infinite where nothing was lost.
  };
  std::optional<Matrix6d> LiveCovariance(const FloorTrack& track, const Pose& X_WC, double since_loss_s) const;
  Matrix6d Spatial(const Pose& X_WC, const Eigen::Matrix3d& planar, double since_loss_s) const;
  void AddKeyframe(const FloorKeyframe& keyframe);

  FloorSlamOptions options_;
  FloorTracker tracker_;
  FloorFilter filter_;
  std::vector<Record> records_;
  bool started_ = false;
  std::optional<int64_t> found_again_ns_;  ///< The first frame aligned after the latest loss.
  std::vector<PlanarPose> keyframes_;      ///< By the tracker.
  /// Below the tracker's present keyframe, and the covariance of its motion since the last one of these.
  PlanarPose present_;
  Eigen::Matrix3d present_covariance_ = Eigen::Matrix3d::Zero();
  std::vector<int64_t> keyframe_ns_;
  std::map<int, size_t> keyframe_of_id_;  ///< Index of the retired ones.
};

}  // namespace gaitcam
