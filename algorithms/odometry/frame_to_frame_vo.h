/// Monocular visual odometry from pairs of frames, in the seven steps of thesis 5.4: features by name, best-bin-first
/// matching, five-point hypotheses judged by MLESAC (or another estimator by name), decomposition by points in front,
/// and the scale handed from one reconstruction to the next by the points they share. No motion model, no loop closure.
///
/// Deviations from the thesis, each an option: a walking camera at 30 Hz moves by millimetres between frames, which
/// leaves the direction of motion to the noise. So a frame becomes the second view of a reconstruction when its points
/// have moved by `pair_displacement_px` (0: every frame, as in the thesis) or too few are left, and frames in between
/// are placed by the reconstruction's points (resection). `placing` points places the second views so too, which was
/// measured to drift several times less than two_view, steps 3 to 6; these steps then only begin a path. `refine`
/// descends to the least Sampson error; `max_rays` above 2 sharpens points by all the pairs that saw them. The thesis
/// itself: placing two_view, refine false, max_rays 2.
///
/// The world frame W is the first chosen frame's camera frame, its unit the median depth there.

#pragma once

#include <memory>
#include <string>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/ransac.h"

namespace gaitcam {

struct FrameToFrameVoOptions {
  using DescribedTag = void;

  std::string feature = "mobif";     ///< Detector by name (algorithms/features/features.h).
  int max_features = 800;            ///< Strongest features kept per frame.
  double sensitivity = 4;            ///< The detector's own threshold is divided by this: blur asks for more.
  MatchingOptions matching;          ///< Step 2. Its fields are fields of these options.
  std::string estimator = "mlesac";  ///< Step 4: ransac | mlesac | preemptive.
  double threshold_px = 2.0;         ///< Largest error of an inlier, px at the image centre.
  bool refine = true;                ///< Least squares after step 5.
  std::string placing = "points";    ///< How a second view is placed: two_view (steps 3 to 6) | points (resection).
  double max_direction_deg = 180;    ///< two_view: largest standard deviation of the direction; else by points.
  double pair_displacement_px = 8;   ///< Median displacement, turning taken off, that makes a pair; 0: every frame.
  double pair_overlap = 0.8;         ///< A frame that shares less than this part of the points makes a pair.
  double scale_tolerance = 0.1;      ///< Step 6: relative deviation of a depth ratio that agrees.
  int max_rays = 12;                 ///< Views that a point is triangulated from: its first and the latest.
  int min_matches = 10;              ///< With fewer inliers a frame has no pose.
  int min_start_points = 40;         ///< Points that a new reconstruction needs.
  double min_parallax_deg = 1.0;     ///< A point is triangulated when its rays meet at this angle.
  double start_parallax_deg = 0.5;   ///< Median angle between the rays of the two frames that begin the path.
  double start_direction_deg = 0.5;  ///< ... and largest standard deviation of their baseline's direction.
  int start_patience_frames = 30;    ///< After so many frames twice, then three times that deviation will do.
  int max_start_misses = 5;          ///< Frames in a row that do not match the first before another is first.
  int max_lost_frames = 15;          ///< After so many frames without a pose the path is begun anew.
  double ransac_confidence = 0.9999;
  int ransac_iterations = 300;  ///< Most samples drawn per frame.

  FrameToFrameVoOptions() { matching.search = "bbf"; }
  /// The defaults with another detector.
  static FrameToFrameVoOptions WithFeature(const std::string& feature, double sensitivity);
};

/// Names of all detectors.
Words FeatureNames();

template <class Visitor>
void VisitFields(Visitor& visit, FrameToFrameVoOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("max_features", o.max_features, Between(50, 100000), "strongest features kept per frame");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  VisitFields(visit, o.matching);
  visit("estimator", o.estimator, RobustEstimators(), "who judges hypotheses");
  visit("threshold_px", o.threshold_px, Between(0.01, 100.0), "largest error of an inlier");
  visit("refine", o.refine, Nested(), "least squares after the decomposition");
  visit("placing", o.placing, OneOf({"two_view", "points"}), "how a second view is placed");
  visit("max_direction_deg", o.max_direction_deg, Between(0.001, 180.0),
        "largest standard deviation of a two-view direction that is believed");
  visit("pair_displacement_px", o.pair_displacement_px, Between(0.0, 1000.0), "median displacement that makes a pair");
  visit("pair_overlap", o.pair_overlap, Between(0.0, 1.0), "part of points shared that makes a pair");
  visit("scale_tolerance", o.scale_tolerance, Between(0.001, 10.0), "relative deviation of a depth ratio that agrees");
  visit("max_rays", o.max_rays, Between(2, 1000), "views that a point is triangulated from");
  visit("min_matches", o.min_matches, Between(6, 100000), "with fewer inliers a frame has no pose");
  visit("min_start_points", o.min_start_points, Between(8, 100000), "points that a new reconstruction needs");
  visit("min_parallax_deg", o.min_parallax_deg, Between(0.01, 45.0), "angle of the rays that make a point");
  visit("start_parallax_deg", o.start_parallax_deg, Between(0.01, 45.0), "median angle that begins a path");
  visit("start_direction_deg", o.start_direction_deg, Between(0.001, 180.0),
        "largest standard deviation of the first baseline's direction");
  visit("start_patience_frames", o.start_patience_frames, Between(1, 1000000),
        "after so many frames twice that deviation will do");
  visit("max_start_misses", o.max_start_misses, Between(0, 1000000),
        "unmatched frames in a row until another is first");
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "frames without a pose until a new start");
  visit("ransac_confidence", o.ransac_confidence, Between(0.5, 0.999999), "chance to have met a clean sample");
  visit("ransac_iterations", o.ransac_iterations, Between(1, 1000000), "most samples drawn per frame");
}

class FrameToFrameVo {
 public:
  /// @throws BadOption if the camera or an option is out of range.
  FrameToFrameVo(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed);
  ~FrameToFrameVo();

  /// Answers one frame. An image without texture, or unlike all before it, is an answer without a pose, never an error.
  /// `restarted` marks the frame that begins a new path: it starts at the last known pose and with the last known
  /// median depth as its unit, which is a guess.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
