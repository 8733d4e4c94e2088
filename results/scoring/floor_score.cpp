#include "results/scoring/floor_score.h"

#include <fmt/format.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/floor_landmarks.h"
#include "results/scoring/floor_overlap.h"
#include "results/scoring/floor_sheet.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

using internal::FloorLandmarkSearch;
using internal::FloorOverlap;
using internal::FloorSheet;
using internal::OddCells;
using internal::WellSeen;

void CheckMap(const FloorPicture& map) {
  if (map.empty()) return;
  if (map.intensity.type() != CV_8UC1) throw BadOption("map: expected intensities of 8 bits");
  if (map.sightings.type() != CV_16UC1 || map.sightings.size() != map.intensity.size()) {
    throw BadOption("map: expected sightings of 16 bits, as many as intensities");
  }
  if (!(map.cell_m > 0)) throw BadOption("map: cell_m: expected a number above 0");
}

void DrawPictures(const FloorPicture& map, const FloorPicture& mapped, const TrueFloor& floor, const FloorTruth& extent,
                  const Correlation& fit, const FloorScoreOptions& options, FloorComparison& result) {
  const FloorSheet sheet(mapped, extent, result.X_WV, options.margin_m);
  if (sheet.empty()) return;
  result.cell_m = map.cell_m;
  result.corner_m = sheet.corner_m();
  const FloorSheet::DrawnMap shown = sheet.Draw(map, result.X_WV, 1);
  const FloorSheet::DrawnMap counted = sheet.Draw(mapped, result.X_WV, options.min_sightings);
  const cv::Mat truth = sheet.DrawTruth(floor);
  shown.grey.convertTo(result.estimate, CV_8U);
  result.mask = internal::MaskPicture(shown.sightings);
  cv::Mat drawn = truth.clone();
  drawn.setTo(0, truth != truth);
  drawn.convertTo(result.truth, CV_8U);
  result.difference = internal::DifferencePicture(counted.grey, truth, counted.seen & (truth == truth), fit,
                                                  FloorComparison::kFullScale_grey);
  result.landmarks = FloorLandmarkSearch(sheet, counted.grey, counted.seen, truth, options).Run();
}

std::vector<double> LandmarkErrors(const std::vector<FloorLandmark>& landmarks) {
  std::vector<double> errors;
  for (const FloorLandmark& l : landmarks) {
    if (l.found) errors.push_back((l.map_m - l.truth_m).norm());
  }
  return errors;
}

/// How far the map's centre moves from one alignment to the other, m.
double Shift(const FloorPicture& mapped, const FloorMotion& from, const FloorMotion& to) {
  const Eigen::Vector2d middle =
      CellMiddle(mapped, (mapped.intensity.cols - 1) / 2.0, (mapped.intensity.rows - 1) / 2.0);
  return (to * middle - from * middle).norm();
}

/// Of map and true floor where an alignment puts the map.
double CorrelationAt(const FloorPicture& mapped, const FloorTruth& whole_truth, const FloorMotion& X_WV,
                     const FloorScoreOptions& options) {
  if (mapped.empty()) return kNaN;
  const FloorTruth truth = internal::CroppedTo(mapped, whole_truth, X_WV, options.margin_m, options.alignment);
  return FloorOverlap(mapped, TrueFloor(truth, mapped.cell_m), X_WV).Correlate().Value();
}

}  // namespace

FloorComparison CompareFloor(const FloorPicture& map, const FloorTruth& whole_truth, const Similarity& X_WV,
                             const FloorScoreOptions& options, const std::optional<Similarity>& X_WV_start) {
  CheckFields(options, "map.");
  CheckMap(map);
  const FloorPicture mapped = WellSeen(map, options.min_sightings);
  FloorComparison result;
  result.X_WV_trajectory = FloorMotion(X_WV);
  const FloorTruth truth =
      internal::CroppedTo(mapped, whole_truth, result.X_WV_trajectory, options.margin_m, options.alignment);
  const TrueFloor floor(truth, map.empty() ? 1 / truth.px_per_m : map.cell_m);
  const FloorOverlap before(mapped, floor, result.X_WV_trajectory);
  const double ncc_before = before.Correlate().Value();
  result.X_WV = AlignFloor(mapped, floor, result.X_WV_trajectory, options.alignment);
  FloorOverlap after(mapped, floor, result.X_WV);
  if (!(after.Correlate().Value() > ncc_before)) {  // the search looked at a part of the cells only
    result.X_WV = result.X_WV_trajectory;
    after = before;
  }
  const Correlation fit = after.Correlate();
  if (!mapped.empty()) DrawPictures(map, mapped, floor, truth, fit, options, result);

  FloorMeasures measures;
  measures.ncc = fit.Value();
  measures.ncc_unaligned = ncc_before;
  measures.ncc_from_start = X_WV_start ? CorrelationAt(mapped, whole_truth, FloorMotion(*X_WV_start), options) : kNaN;
  measures.ncc_local =
      after.WithoutLocalMean(map.empty() ? 1 : OddCells(options.local_window_m, map.cell_m)).Correlate().Value();
  measures.area_m2 = double(fit.count()) * (map.cell_m * map.cell_m);
  measures.outside_ratio = after.mapped > 0 ? 1 - double(fit.count()) / double(after.mapped) : kNaN;
  measures.shift_m = mapped.empty() ? kNaN : Shift(mapped, result.X_WV_trajectory, result.X_WV);
  measures.turn_deg = mapped.empty() ? kNaN : (result.X_WV.yaw - result.X_WV_trajectory.yaw) * 180 / kPi;
  measures.landmarks = double(result.landmarks.size());
  measures.landmark_errors_m = LandmarkErrors(result.landmarks);
  result.scores = Evaluate(FloorMetrics(options), measures);
  return result;
}

std::vector<Metric<FloorMeasures>> FloorMetrics(const FloorScoreOptions& options) {
  constexpr ScoreGroup kGroup = ScoreGroup::kMap;
  return {
      {"map_ncc", "", Better::kHigher, kGroup, "correlation of mapped and true floor, cell by cell, pictures aligned",
       [](const auto& m) { return m.ncc; }, true},
      {"map_ncc_unaligned", "", Better::kHigher, kGroup,
       "the same where the trajectories' SE(3) alignment puts the map", [](const auto& m) { return m.ncc_unaligned; }},
      {"map_ncc_from_start", "", Better::kHigher, kGroup, "the same where the first pose puts it: nothing is aligned",
       [](const auto& m) { return m.ncc_from_start; }},
      {"map_ncc_local", "", Better::kHigher, kGroup,
       fmt::format("the same as map_ncc without each one's mean over {:g} m around: detail alone",
                   options.local_window_m),
       [](const auto& m) { return m.ncc_local; }},
      {"map_area_m2", "m2", Better::kHigher, kGroup,
       fmt::format("floor that was seen {} times or more often", options.min_sightings),
       [](const auto& m) { return m.area_m2; }},
      {"map_outside_ratio", "", Better::kLower, kGroup, "part of the map that lies beyond the true floor's edges",
       [](const auto& m) { return m.outside_ratio; }},
      {"map_shift_m", "m", Better::kNeither, kGroup, "how far the pictures' alignment moves the map",
       [](const auto& m) { return m.shift_m; }},
      {"map_turn_deg", "deg", Better::kNeither, kGroup, "how far it turns the map to the left",
       [](const auto& m) { return m.turn_deg; }},
      {"map_landmarks", "", Better::kNeither, kGroup, "corners of the true floor on mapped ground",
       [](const auto& m) { return m.landmarks; }},
      {"map_landmarks_found_ratio", "", Better::kHigher, kGroup,
       fmt::format("part of them that the map clearly shows within {:g} m", options.landmark_search_m),
       [](const auto& m) { return m.landmarks > 0 ? double(m.landmark_errors_m.size()) / m.landmarks : kNaN; }},
      {"map_landmark_error_median_m", "m", Better::kLower, kGroup, "how far off the map shows them, median",
       [](const auto& m) { return MedianOf(m.landmark_errors_m); }, true},
      {"map_landmark_error_p90_m", "m", Better::kLower, kGroup, "how far off the map shows them, 90th percentile",
       [](const auto& m) { return QuantileOf(m.landmark_errors_m, 0.9); }}};
}

}  // namespace gaitcam
