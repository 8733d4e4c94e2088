/// Plain monocular visual odometry: SIFT, ratio test, five-point RANSAC, triangulation, three-point RANSAC, and the
/// scale carried along by points that successive keyframes share. The honest baseline: no bundle adjustment, no motion
/// model but "near where it was", no loop closure, no blur handling.
///
/// Every frame is matched with one keyframe. A walking camera moves by millimetres between frames, so points are
/// triangulated only between keyframes that are far enough apart to see parallax; frames in between are placed by the
/// points of the keyframe. The world frame W is the first keyframe's camera frame, its unit the median depth there.

#pragma once

#include <memory>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"

namespace gaitcam {

struct SiftVoOptions {
  using DescribedTag = void;

  int max_features = 800;              ///< Strongest SIFT features kept per frame.
  double sensitivity = 4;              ///< SIFT's contrast threshold is 0.04 divided by this: blur asks for more.
  double ratio = 0.8;                  ///< Ratio test (Lowe 2004).
  double threshold_px = 2.0;           ///< Largest error of an inlier, px at the image centre.
  int min_matches = 10;                ///< With fewer inliers a frame has no pose.
  int min_start_points = 40;           ///< Points that a new map needs.
  double min_parallax_deg = 1.0;       ///< A point is triangulated when its rays meet at this angle.
  double start_parallax_deg = 0.5;     ///< Median angle between the rays of the two frames that start a map.
  double start_direction_deg = 1.0;    ///< ... and the largest standard deviation of the direction of their baseline.
  double keyframe_parallax_deg = 4.0;  ///< Median angle that makes a frame a keyframe.
  double keyframe_overlap = 0.3;       ///< A frame that shares less than this part of its points becomes a keyframe.
  int max_lost_frames = 15;            ///< After so many frames without a pose the map is given up and begun anew.
  double ransac_confidence = 0.9999;
  int ransac_iterations = 300;  ///< Most samples drawn per frame.
};

template <class Visitor>
void VisitFields(Visitor& visit, SiftVoOptions& o) {
  visit("max_features", o.max_features, Between(50, 100000), "strongest SIFT features kept per frame");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  visit("ratio", o.ratio, Between(0.1, 1.0), "ratio test: nearest over second nearest distance");
  visit("threshold_px", o.threshold_px, Between(0.01, 100.0), "largest error of an inlier");
  visit("min_matches", o.min_matches, Between(6, 100000), "with fewer inliers a frame has no pose");
  visit("min_start_points", o.min_start_points, Between(8, 100000), "points that a new map needs");
  visit("min_parallax_deg", o.min_parallax_deg, Between(0.01, 45.0), "angle of the rays that make a point");
  visit("start_parallax_deg", o.start_parallax_deg, Between(0.01, 45.0), "median angle that starts a map");
  visit("start_direction_deg", o.start_direction_deg, Between(0.001, 180.0),
        "largest standard deviation of the first baseline's direction");
  visit("keyframe_parallax_deg", o.keyframe_parallax_deg, Between(0.1, 90.0), "median angle that makes a keyframe");
  visit("keyframe_overlap", o.keyframe_overlap, Between(0.0, 1.0), "part of points shared that makes a keyframe");
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "frames without a pose until a new start");
  visit("ransac_confidence", o.ransac_confidence, Between(0.5, 0.999999), "chance to have met a clean sample");
  visit("ransac_iterations", o.ransac_iterations, Between(1, 1000000), "most samples drawn per frame");
}

class SiftVo {
 public:
  /// @throws BadOption if the camera or an option is out of range.
  SiftVo(const CameraModel& camera, const SiftVoOptions& options, uint64_t seed);
  ~SiftVo();

  /// Answers one frame. An image without texture, or unlike all before it, is an answer without a pose, never an error.
  /// `restarted` marks the frame that begins a new map: it starts at the last known pose and with the last known median
  /// depth as its unit, which is a guess.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
