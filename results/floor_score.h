/// A mapped floor against the true one: how alike they look, and how far off lies what both show.
///
/// The map's frame is a gauge freedom as the trajectory's is, so the map is judged where the SE(3) alignment of the
/// trajectories puts it, and once more after the small rigid motion on the floor (no scale: that is the system's
/// business) under which the two pictures correlate best. Both figures are given.
///
/// The truth is averaged over the area of each of the map's cells; nothing is done to the map. Brightness need not
/// agree: correlation does not see gain and offset.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/floor_picture.h"
#include "results/floor_alignment.h"
#include "results/score.h"

namespace gaitcam {

struct FloorScoreOptions {
  using DescribedTag = void;
  int min_sightings = 3;             ///< A cell that was seen less often does not count as mapped.
  double local_window_m = 0.1;       ///< Side of the square whose mean `map_ncc_local` takes away.
  double landmark_spacing_m = 0.06;  ///< Landmarks keep this distance from each other.
  double landmark_quality = 0.05;    ///< Least corner strength, of the strongest one's (Shi and Tomasi, CVPR 1994).
  double landmark_patch_m = 0.065;   ///< Side of the square of true floor that is looked for in the map.
  double landmark_search_m = 0.04;   ///< ... this far from where it ought to be, along x and y each.
  double landmark_peak = 0.7;        ///< Least correlation of a landmark that counts as found ...
  double landmark_lead = 0.1;        ///< ... and by this it beats the best one elsewhere in the search.
  double margin_m = 0.1;             ///< Of the pictures, about what was mapped.
  FloorAlignmentOptions alignment;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorScoreOptions& o) {
  visit("min_sightings", o.min_sightings, Between(1, 65535), "a cell that was seen less often does not count");
  visit("local_window_m", o.local_window_m, Between(1e-3, 100), "window of the local mean");
  visit("landmark_spacing_m", o.landmark_spacing_m, Between(1e-3, 100), "distance of landmarks");
  visit("landmark_quality", o.landmark_quality, Between(1e-6, 1), "least corner strength, of the strongest");
  visit("landmark_patch_m", o.landmark_patch_m, Between(1e-3, 10), "side of what is looked for");
  visit("landmark_search_m", o.landmark_search_m, Between(1e-3, 10), "how far it is looked for");
  visit("landmark_peak", o.landmark_peak, Between(0, 1), "least correlation of a found landmark");
  visit("landmark_lead", o.landmark_lead, Between(0, 1), "over the best one elsewhere");
  visit("margin_m", o.margin_m, Between(0, 100), "of the pictures");
  visit("alignment", o.alignment, Nested(), "of the map with the floor");
}

/// A corner of the true floor, and where the map shows it.
struct FloorLandmark {
  Eigen::Vector2d truth_m = Eigen::Vector2d::Zero();  ///< In W.
  Eigen::Vector2d map_m = Eigen::Vector2d::Zero();    ///< In W, after the refined alignment; only if it was found.
  bool found = false;
};

/// How good a map is, and pictures of it. They have the same size and show the same ground in W: where the map and the
/// true floor meet, with a margin; `cell_m` per pixel, row 0 towards +y.
struct FloorComparison {
  static constexpr int kFullScale_grey = 64;  ///< Of `difference`: a larger difference looks no different.

  double cell_m = 0;
  Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  ///< x, y in W of the centre of the pixel in row 0, column 0.
  cv::Mat estimate;                                    ///< CV_8UC1: the map; black where nothing was seen.
  cv::Mat mask;        ///< CV_8UC1: how often each cell was seen, logarithmic: 0 never, 255 the most of all.
  cv::Mat truth;       ///< CV_8UC1: the same ground as it is; black beyond the floor.
  cv::Mat difference;  ///< CV_8UC3: the map with best gain and offset minus the truth: white equal, red too bright,
                       ///< blue too dark; dark where there is nothing to compare.

  FloorMotion X_WV_trajectory;           ///< As the trajectories align.
  FloorMotion X_WV;                      ///< As the pictures align; the former where that is no better.
  std::vector<FloorLandmark> landmarks;  ///< Those on mapped ground.
  std::vector<Score> scores;             ///< `map_...`; NaN where the map does not determine one.

  bool empty() const { return estimate.empty(); }  ///< Nothing was seen often enough, or nothing of it is floor.
};

/// Compares a map with the truth.
/// @param map in the plane z = 0 of the estimator's world V. @param X_WV aligns the trajectories, SE(3).
/// @throws BadOption for options, a map or a truth that contradict themselves.
FloorComparison CompareFloor(const FloorPicture& map, const FloorTruth& truth, const Similarity& X_WV,
                             const FloorScoreOptions& options = {});

}  // namespace gaitcam
