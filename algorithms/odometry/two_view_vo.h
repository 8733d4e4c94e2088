/// Monocular visual odometry from pairs of successive frames: the seven steps of
///   A. Pretto, "Visual-SLAM for Humanoid Robots", Ph.D. thesis, University of Padua, section 5.4
/// and, unless a filter of matches is asked for, nothing else. No landmarks, no refinement, no motion model; every
/// frame is paired with the one before it.
///
/// 1. Features of the frame, by a detector with its standard threshold.
/// 2. Matches with the frame before, nearest neighbours by best bin first. `match_filter` lets fewer of them pass: that
///    is the odometry of Hua, section 6.2, which does not tell the steps after it.
/// 3. Hypotheses of the essential matrix from five matches each.
/// 4. The most likely one by MLESAC; errors are distances from epipolar lines.
/// 5. Of its four decompositions the one with most points in front of both cameras.
/// 6. Its scale: RANSAC over the ratios of depths in the common frame, of points that this pair and the pair before it
///    both reconstruct. The first pair's baseline is the unit of length.
/// 7. On to the next frame.
///
/// Where a step fails the frame has no pose, and the loop starts over with the next pair as its first: at the last
/// known pose, with a baseline of unit length again. The thesis does not say what it did then.
///
/// A camera that stands still, only turns, or moves by millimetres between frames leaves steps 5 and 6 to noise; that
/// is what KeyframeVo (keyframe_vo.h) is for.

#pragma once

#include <memory>
#include <string>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/match_filter.h"
#include "algorithms/features/matching.h"
#include "algorithms/odometry/frame_view.h"

namespace gaitcam {

struct TwoViewVoOptions {
  using DescribedTag = void;

  std::string feature = "mobif";  ///< Detector by name; the thesis's own is MoBIF (section 5.3).
  int max_features = 2000;        ///< Strongest features kept per frame: more than a frame of VGA size has.
  MatchingOptions matching;       ///< Step 2. Its fields are fields of these options ...
  MatchFilterOptions filter;      ///< ... and so are those of this.
  double threshold_px = 2.0;      ///< Step 4: largest distance of an inlier from its epipolar line, px.
  double confidence = 0.9999;     ///< Steps 4 and 6: probability of a sample without outliers.
  int max_iterations = 300;       ///< Steps 4 and 6: largest number of samples.
  double scale_tolerance = 0.1;   ///< Step 6: relative deviation of an inlier's ratio of depths.
  int min_points = 8;             ///< Matches, inliers of step 4 and of step 6; with fewer the pair has failed.

  TwoViewVoOptions() { matching.search = NeighbourSearch::kBestBinFirst; }
  /// With SURF and ICGM as Hua has them (sections 4.1 and 5.1).
  static TwoViewVoOptions OfCrowds();
};

template <class Visitor>
void VisitFields(Visitor& visit, TwoViewVoOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("max_features", o.max_features, Between(50, 100000), "strongest features kept per frame");
  VisitFields(visit, o.matching);
  VisitFields(visit, o.filter);
  visit("threshold_px", o.threshold_px, Between(0.01, 100.0), "largest distance from the epipolar line, px");
  visit("confidence", o.confidence, Between(0.5, 0.999999), "probability of a sample without outliers");
  visit("max_iterations", o.max_iterations, Between(1, 1000000), "largest number of samples");
  visit("scale_tolerance", o.scale_tolerance, Between(0.001, 10.0), "relative deviation of an inlier's depth ratio");
  visit("min_points", o.min_points, Between(5, 100000), "with fewer points a pair of frames has failed");
}

class TwoViewVo {
 public:
  /// @throws BadOption if the camera or an option is out of range.
  TwoViewVo(const CameraModel& camera, const TwoViewVoOptions& options, uint64_t seed);
  ~TwoViewVo();

  /// Answers one frame. The first has no pose: it is the world frame W, but nothing is known until the second. Failure
  /// is an answer without a pose, never an error. `restarted` marks the first pose after one.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace gaitcam
