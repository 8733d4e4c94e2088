/// Comparison of a mapped floor with the true one: similarity of the images, and position errors of landmarks.
///
/// The map's frame is a gauge freedom as the trajectory's is, so the map is judged where the SE(3) alignment of the
/// trajectories puts it, and once more after the small rigid motion on the floor (no scale: that is the system's
/// business) under which the two pictures correlate best. Both figures are given, and a third, which takes nothing from
/// the truth but where the robot started.
///
/// The truth is averaged over the area of each of the map's cells; nothing is done to the map. Brightness need not
/// agree: correlation is invariant to gain and offset.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/floor_picture.h"
#include "results/scoring/floor_alignment.h"
#include "results/scoring/metric.h"

namespace gaitcam {

struct FloorScoreOptions {
  using DescribedTag = void;
  int min_sightings = 3;
  double local_window_m = 0.1;
  double landmark_spacing_m = 0.06;
  double landmark_quality = 0.05;
  double landmark_patch_m = 0.065;
  double landmark_search_m = 0.04;
  double landmark_peak = 0.7;
  double landmark_lead = 0.1;
  double margin_m = 0.1;
  FloorAlignmentOptions alignment;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorScoreOptions& o) {
  visit("min_sightings", o.min_sightings, Between(1, 65535),
        "a cell that was seen less often does not count as mapped");
  visit("local_window_m", o.local_window_m, Between(1e-3, 100),
        "side of the square whose mean `map_ncc_local` takes away");
  visit("landmark_spacing_m", o.landmark_spacing_m, Between(1e-3, 100), "minimum distance between two landmarks");
  visit("landmark_quality", o.landmark_quality, Between(1e-6, 1),
        "minimum corner strength as a part of the strongest one's (Shi and Tomasi, CVPR 1994)");
  visit("landmark_patch_m", o.landmark_patch_m, Between(1e-3, 10),
        "side of the square of true floor that is looked for in the map");
  visit("landmark_search_m", o.landmark_search_m, Between(1e-3, 10),
        "half the side of the square that is searched, about the true position");
  visit("landmark_peak", o.landmark_peak, Between(0, 1), "minimum correlation of a landmark that counts as found");
  visit("landmark_lead", o.landmark_lead, Between(0, 1),
        "minimum by which a landmark's correlation exceeds the best elsewhere in the search");
  visit("margin_m", o.margin_m, Between(0, 100), "of the pictures, about what was mapped");
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
/// @param X_WV_start aligns the first poses alone.
/// @throws BadOption for options, a map or a truth that contradict themselves.
FloorComparison CompareFloor(const FloorPicture& map, const FloorTruth& truth, const Similarity& X_WV,
                             const FloorScoreOptions& options = {},
                             const std::optional<Similarity>& X_WV_start = std::nullopt);

/// What the metrics of a floor map take their values from; NaN where the map does not determine one.
struct FloorMeasures {
  double ncc = 0;  ///< After the pictures' alignment; next as the trajectories align.
  double ncc_unaligned = 0;
  double ncc_from_start = 0;         ///< As the first poses align.
  double ncc_local = 0;              ///< Without the local means.
  double area_m2 = 0;                ///< Mapped and on the true floor.
  double outside_ratio = 0;          ///< Mapped and not on it, of all that was mapped.
  double shift_m = 0, turn_deg = 0;  ///< Of the pictures' alignment against the trajectories'.
  double landmarks = 0;
  std::vector<double> landmark_errors_m;  ///< Of those that were found.
};
std::vector<Metric<FloorMeasures>> FloorMetrics(const FloorScoreOptions& options);

}  // namespace gaitcam
