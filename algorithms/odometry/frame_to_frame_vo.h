/// Monocular visual odometry from pairs of frames, in the seven steps of thesis 5.4: features by name, best-bin-first
/// matching, five-point hypotheses judged by MLESAC (or another estimator by name), decomposition by points in front,
/// and the scale handed from one reconstruction to the next by the points they share. No loop closure, and no motion
/// model but that a walker's camera is about where it was.
///
/// Deviations from the thesis, each an option: a walking camera at 30 Hz moves by millimetres between frames, which
/// leaves the direction of motion to the noise. So a frame is chosen as the second view of a reconstruction when its
/// points have moved by `pair_displacement_px` (0: every frame, as in the thesis), and as one that sees well: what a
/// blurred frame does not see is not thereby gone. Points are remembered for `memory` chosen frames, and all frames in
/// between are placed by them (resection), each point weighed by what is known of its depth. `placing` points places
/// the chosen frames so too, and refines the last `window` of them together with their points (bundle adjustment:
/// without it, scale drifts by percents per metre); two_view, steps 3 to 6, then only begins a path. `refine` descends
/// to the least Sampson error. The thesis itself: placing two_view, refine false, pair_displacement_px 0.
///
/// The world frame W is the first chosen frame's camera frame, its unit the median depth there.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/ransac.h"
#include "algorithms/odometry/landmark_pose.h"

namespace gaitcam {

struct FrameToFrameVoOptions {
  using DescribedTag = void;

  std::string feature = "mobif";     ///< Detector by name (algorithms/features/features.h).
  int max_features = 800;            ///< Strongest features kept per frame.
  double sensitivity = 4;            ///< The detector's own threshold is divided by this: blur asks for more.
  MatchingOptions matching;          ///< Step 2. Its fields are fields of these options.
  std::string estimator = "mlesac";  ///< Step 4: ransac | mlesac | preemptive.
  double threshold_px = 2.0;         ///< Largest error of an inlier of two views, px at the image centre.
  bool refine = true;                ///< Least squares after step 5.
  std::string placing = "points";    ///< How a chosen frame is placed: two_view (steps 3 to 6) | points (resection).
  double max_direction_deg = 180;    ///< two_view: largest standard deviation of the direction; else by points.
  double scale_tolerance = 0.1;      ///< Step 6: relative deviation of a depth ratio that agrees.
  double min_parallax_deg = 1.0;     ///< Step 6: a depth is a pair's when its rays meet at this angle.

  LandmarkPoseOptions landmarks;  ///< How a frame is placed by points. Its fields are fields of these options.

  double pair_displacement_px = 8;  ///< Median displacement, turning taken off, that makes a pair; 0: every frame.
  double pair_turn_deg = 12;        ///< So does a turn by this angle.
  double pair_overlap = 0.6;        ///< So do frames that see less than this part of the points.
  int max_wait_frames = 10;         ///< A pair that is due waits at most so long for a frame that sees well.
  int window = 8;                   ///< points: chosen frames that are refined together with their points; 0: none.
  bool use_floor = true;            ///< points: what is seen on the floor has the depth that the camera's height tells.
  int memory = 20;                  ///< Chosen frames after which a point that was not seen again is forgotten.

  int min_start_points = 40;         ///< Points that a new reconstruction needs.
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
  visit("scale_tolerance", o.scale_tolerance, Between(0.001, 10.0), "relative deviation of a depth ratio that agrees");
  visit("min_parallax_deg", o.min_parallax_deg, Between(0.01, 45.0), "angle of the rays that give a pair's depth");
  VisitFields(visit, o.landmarks);
  visit("pair_displacement_px", o.pair_displacement_px, Between(0.0, 1000.0), "median displacement that makes a pair");
  visit("pair_turn_deg", o.pair_turn_deg, Between(0.1, 180.0), "turn that makes a pair");
  visit("pair_overlap", o.pair_overlap, Between(0.0, 1.0), "part of points still seen that makes a pair");
  visit("max_wait_frames", o.max_wait_frames, Between(0, 1000), "how long a due pair waits for a good frame");
  visit("window", o.window, Between(0, 1000), "chosen frames refined together with their points");
  visit("use_floor", o.use_floor, Nested(), "points: depths and scale by the camera's height over the floor");
  visit("memory", o.memory, Between(1, 100000), "chosen frames until an unseen point is forgotten");
  visit("min_start_points", o.min_start_points, Between(8, 100000), "points that a new reconstruction needs");
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
  /// median depth as its unit, which is a guess. It marks, too, a frame that many points place farther from the last
  /// one than `usual_speed` makes believable.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

  /// The final word on every frame: where later pairs have refined chosen frames, the frames about them move along.
  /// Frames that waited for a reconstruction to begin are placed by it; the first of them is then the one that is
  /// marked `restarted`.
  std::vector<FrameEstimate> Finish() const;

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
