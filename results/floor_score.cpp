#include "results/floor_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "algorithms/core/errors.h"
#include "results/statistics.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void CheckMap(const FloorPicture& map) {
  if (map.empty()) return;
  if (map.intensity.type() != CV_8UC1) throw BadOption("map: expected intensities of 8 bits");
  if (map.sightings.type() != CV_16UC1 || map.sightings.size() != map.intensity.size()) {
    throw BadOption("map: expected sightings of 16 bits, as many as intensities");
  }
  if (!(map.cell_m > 0)) throw BadOption("map: cell_m: expected a number above 0");
}

/// The part of the map that counts: cells that were seen often enough, without the empty rim.
FloorPicture Mapped(const FloorPicture& map, int min_sightings) {
  FloorPicture mapped;
  mapped.cell_m = map.cell_m;
  const cv::Mat often = map.empty() ? cv::Mat() : cv::Mat(map.sightings >= min_sightings);
  const cv::Rect box = map.empty() ? cv::Rect() : cv::boundingRect(often);
  if (box.empty()) return mapped;
  mapped.corner_m = CellMiddle(map, box.x, box.y);
  mapped.intensity = map.intensity(box);
  map.sightings(box).copyTo(mapped.sightings, often(box));
  return mapped;
}

/// The part of the truth that can matter to a map, so that a small map of a large hall costs little.
FloorTruth Cropped(const FloorTruth& truth, const FloorPicture& mapped, const FloorMotion& X_WV,
                   const FloorScoreOptions& options) {
  if (mapped.empty() || truth.grey.empty() || !(truth.px_per_m > 0)) return truth;
  const cv::Size size = mapped.intensity.size();
  const double diagonal = mapped.cell_m * std::hypot(size.width, size.height);
  // A turn moves no cell further than it would at the other end of the diagonal.
  const double reach = diagonal / 2 + options.margin_m + 2 * options.alignment.max_shift_m +
                       diagonal * options.alignment.max_turn_deg * std::numbers::pi / 180;
  const Vector2d middle = X_WV * CellMiddle(mapped, (size.width - 1) / 2.0, (size.height - 1) / 2.0);
  const Eigen::Array2d low =  // column and row
      ((middle - truth.corner_m).array() * Eigen::Array2d(1, -1) - reach) * truth.px_per_m;
  const double side = 2 * reach * truth.px_per_m;
  const auto clip = [](double value, int most) { return int(std::clamp(value, 0.0, double(most))); };
  const cv::Point from(clip(std::floor(low.x()), truth.grey.cols), clip(std::floor(low.y()), truth.grey.rows));
  const cv::Point to(clip(std::ceil(low.x() + side) + 1, truth.grey.cols),
                     clip(std::ceil(low.y() + side) + 1, truth.grey.rows));
  const cv::Rect part(from, to);
  if (part.empty()) return truth;
  return {truth.grey(part), truth.px_per_m, truth.corner_m + Vector2d(from.x, -from.y) / truth.px_per_m};
}

/// The true floor at the map's own cells: CV_32FC1, kBeyond where there is none.
cv::Mat TruthAtCells(const FloorPicture& map, const TrueFloor& truth, const FloorMotion& X_WV) {
  cv::Mat at(map.intensity.size(), CV_32FC1, cv::Scalar(TrueFloor::kBeyond));
  for (int v = 0; v < at.rows; ++v) {
    for (int u = 0; u < at.cols; ++u) {
      if (map.sightings.at<uint16_t>(v, u) > 0) {
        at.at<float>(v, u) = truth.Mean(X_WV * CellMiddle(map, u, v), X_WV.yaw);
      }
    }
  }
  return at;
}

/// What was mapped, cell by cell, and what is true there.
struct Overlap {
  cv::Mat map, truth;  ///< CV_32FC1
  cv::Mat both;        ///< CV_8UC1: 255 where there are both.
  int64_t mapped = 0;  ///< Cells, also those beyond the floor.

  Overlap(const FloorPicture& picture, const TrueFloor& floor, const FloorMotion& X_WV) {
    if (picture.empty()) return;
    picture.intensity.convertTo(map, CV_32F);
    truth = TruthAtCells(picture, floor, X_WV);
    both = truth == truth;  // not NaN
    truth.setTo(0, ~both);
    mapped = cv::countNonZero(picture.sightings);
  }

  Correlation Correlate() const {
    Correlation correlation;
    for (int v = 0; v < both.rows; ++v) {
      for (int u = 0; u < both.cols; ++u) {
        if (both.at<uchar>(v, u)) correlation.Add(map.at<float>(v, u), truth.at<float>(v, u));
      }
    }
    return correlation;
  }

  /// Minus its mean over those of `window` x `window` cells around that count.
  Overlap WithoutLocalMean(int window) const {
    Overlap local = *this;
    if (both.empty()) return local;
    cv::Mat weight, near;
    both.convertTo(weight, CV_32F, 1.0 / 255);
    cv::boxFilter(weight, near, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
    for (cv::Mat* picture : {&local.map, &local.truth}) {
      cv::Mat sum;
      cv::boxFilter(picture->mul(weight), sum, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
      *picture = *picture - sum / cv::max(near, 1);
    }
    return local;
  }
};

int OddCells(double side_m, double cell_m) { return 2 * std::max(1, int(std::lround(side_m / cell_m / 2))) + 1; }

/// Map and truth drawn upright in W.
class Sheet {
 public:
  /// @param map what counts of it. @pre not empty
  Sheet(const FloorPicture& map, const FloorTruth& floor, const FloorMotion& X_WV, double margin_m)
      : cell_m_(map.cell_m) {
    Vector2d low = Vector2d::Constant(1e300), high = -low;
    for (int v = 0; v < map.sightings.rows; ++v) {
      for (int u = 0; u < map.sightings.cols; ++u) {
        if (map.sightings.at<uint16_t>(v, u) == 0) continue;
        const Vector2d p = X_WV * CellMiddle(map, u, v);
        if ((p.array() < floor.Min().array()).any() || (p.array() > floor.Max().array()).any()) continue;
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    if (low.x() > high.x()) return;
    const Vector2d size = (high - low) / cell_m_ + Vector2d::Constant(2 * margin_m / cell_m_ + 1);
    size_ = {int(std::ceil(size.x())), int(std::ceil(size.y()))};
    corner_m_ = {low.x() - margin_m, high.y() + margin_m};
  }

  bool empty() const { return size_.empty(); }
  cv::Size size() const { return size_; }
  Vector2d corner_m() const { return corner_m_; }
  Vector2d Middle(double u, double v) const { return corner_m_ + cell_m_ * Vector2d(u, -v); }

  struct DrawnMap {
    cv::Mat grey;       ///< CV_32FC1, 0 where not seen.
    cv::Mat seen;       ///< CV_8UC1
    cv::Mat sightings;  ///< CV_16UC1
  };
  /// The map between its cells: bilinear over those that were seen at least `min_sightings` times.
  DrawnMap Draw(const FloorPicture& map, const FloorMotion& X_WV, int min_sightings) const {
    const FloorMotion X_VW = X_WV.Inverse();
    cv::Mat map_x(size_, CV_32FC1), map_y(size_, CV_32FC1);
    for (int v = 0; v < size_.height; ++v) {
      for (int u = 0; u < size_.width; ++u) {
        const Vector2d at = (X_VW * Middle(u, v) - map.corner_m) / cell_m_;
        map_x.at<float>(v, u) = float(at.x());
        map_y.at<float>(v, u) = float(-at.y());
      }
    }
    cv::Mat weight, grey, drawn_weight;
    DrawnMap drawn;
    cv::Mat(map.sightings >= min_sightings).convertTo(weight, CV_32F, 1.0 / 255);
    map.intensity.convertTo(grey, CV_32F);
    cv::remap(grey.mul(weight), drawn.grey, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    cv::remap(weight, drawn_weight, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    cv::remap(map.sightings, drawn.sightings, map_x, map_y, cv::INTER_NEAREST, cv::BORDER_CONSTANT);
    drawn.seen = drawn_weight >= 0.5;
    drawn.grey = drawn.grey / cv::max(drawn_weight, 0.5);
    drawn.grey.setTo(0, ~drawn.seen);
    return drawn;
  }

  /// CV_32FC1; kBeyond where there is no floor.
  cv::Mat DrawTruth(const TrueFloor& floor) const {
    cv::Mat truth(size_, CV_32FC1);
    for (int v = 0; v < size_.height; ++v) {
      for (int u = 0; u < size_.width; ++u) truth.at<float>(v, u) = floor.Mean(Middle(u, v), 0);
    }
    return truth;
  }

 private:
  double cell_m_;
  cv::Size size_;
  Vector2d corner_m_ = Vector2d::Zero();
};

cv::Mat MaskPicture(const cv::Mat& sightings) {
  cv::Mat mask;
  sightings.convertTo(mask, CV_32F);
  cv::log(mask + 1, mask);
  double most = 0;
  cv::minMaxLoc(mask, nullptr, &most);
  mask.convertTo(mask, CV_8U, most > 0 ? 255 / most : 0);
  return mask;
}

cv::Mat DifferencePicture(const cv::Mat& map, const cv::Mat& truth, const cv::Mat& both, const Correlation& fit) {
  constexpr int kNothing = 40;  // grey of what cannot be compared
  cv::Mat picture(map.size(), CV_8UC3, cv::Scalar::all(kNothing));
  const bool known = !std::isnan(fit.Gain());
  for (int v = 0; v < map.rows && known; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (!both.at<uchar>(v, u)) continue;
      const double e = fit.Gain() * map.at<float>(v, u) + fit.Offset() - truth.at<float>(v, u);
      const uchar rest = cv::saturate_cast<uchar>(255 * (1 - std::abs(e) / FloorComparison::kFullScale_grey));
      picture.at<cv::Vec3b>(v, u) = e > 0 ? cv::Vec3b(rest, rest, 255) : cv::Vec3b(255, rest, rest);
    }
  }
  return picture;
}

// ---- Landmarks
// -------------------------------------------------------------------------------------------------------

/// Where a parabola through three values at -1, 0, 1 has its top; the middle one is the largest.
double Top(double before, double middle, double after) {
  const double bend = before - 2 * middle + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

class LandmarkSearch {
 public:
  /// Pictures drawn upright in W, CV_32FC1; `seen` where the map counts.
  LandmarkSearch(const Sheet& sheet, const cv::Mat& map, const cv::Mat& seen, const cv::Mat& truth, double cell_m,
                 const FloorScoreOptions& options)
      : sheet_(sheet), options_(options), map_(map.clone()), truth_(truth.clone()), cell_m_(cell_m) {
    half_ = OddCells(options.landmark_patch_m, cell_m) / 2;
    search_ = std::max(1, int(std::lround(options.landmark_search_m / cell_m)));
    const cv::Mat floor = truth == truth;
    truth_.setTo(0, ~floor);
    // Holes of a few cells are no reason to leave a place out; they are filled so that they hold no structure.
    const int window = 2 * (half_ + search_) + 1;
    constexpr double kSeenPart = 0.9;
    cv::Mat weight, near, sum;
    cv::Mat(seen & floor).convertTo(weight, CV_32F, 1.0 / 255);
    cv::boxFilter(weight, near, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
    cv::boxFilter(map_.mul(weight), sum, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
    cv::Mat(sum / cv::max(near, 1e-6)).copyTo(map_, ~seen);
    usable_ = near >= kSeenPart;
    const int rim = half_ + search_;
    cv::Mat inside = cv::Mat::zeros(usable_.size(), CV_8UC1);
    if (usable_.cols > 2 * rim && usable_.rows > 2 * rim) {
      const cv::Rect within(rim, rim, usable_.cols - 2 * rim, usable_.rows - 2 * rim);
      usable_(within).copyTo(inside(within));
    }
    usable_ = inside;
  }

  std::vector<FloorLandmark> Run() const {
    std::vector<cv::Point2f> corners;
    if (cv::countNonZero(usable_) > 0) {
      cv::goodFeaturesToTrack(truth_, corners, 0, options_.landmark_quality, options_.landmark_spacing_m / cell_m_,
                              usable_);
    }
    std::vector<FloorLandmark> landmarks;
    for (const cv::Point2f& corner : corners) {
      const cv::Point at(int(std::lround(corner.x)), int(std::lround(corner.y)));
      FloorLandmark landmark;
      landmark.truth_m = sheet_.Middle(at.x, at.y);
      if (const std::optional<Vector2d> found = Find(at)) {
        landmark.found = true;
        landmark.map_m = sheet_.Middle(found->x(), found->y());
      }
      landmarks.push_back(landmark);
    }
    return landmarks;
  }

 private:
  /// Where the map shows the true patch around `at`, between pixels; nothing without one clear peak.
  std::optional<Vector2d> Find(cv::Point at) const {
    const int reach = half_ + search_;
    const cv::Mat patch = truth_(cv::Rect(at.x - half_, at.y - half_, 2 * half_ + 1, 2 * half_ + 1));
    const cv::Mat around = map_(cv::Rect(at.x - reach, at.y - reach, 2 * reach + 1, 2 * reach + 1));
    cv::Mat score;
    cv::matchTemplate(around, patch, score, cv::TM_CCOEFF_NORMED);
    double peak = 0;
    cv::Point best;
    cv::minMaxLoc(score, nullptr, &peak, nullptr, &best);
    if (!(peak >= options_.landmark_peak)) return std::nullopt;
    if (best.x == 0 || best.y == 0 || best.x + 1 == score.cols || best.y + 1 == score.rows) return std::nullopt;
    if (peak - BestElsewhere(score, best) < options_.landmark_lead) return std::nullopt;
    const auto value = [&](int du, int dv) { return double(score.at<float>(best.y + dv, best.x + du)); };
    const Vector2d top(Top(value(-1, 0), peak, value(1, 0)), Top(value(0, -1), peak, value(0, 1)));
    return Vector2d(at.x - search_ + best.x, at.y - search_ + best.y) + top;
  }

  /// A peak's own hill reaches as far as half of what is looked for.
  double BestElsewhere(const cv::Mat& score, cv::Point best) const {
    cv::Mat elsewhere(score.size(), CV_8UC1, cv::Scalar(255));
    cv::circle(elsewhere, best, half_, cv::Scalar(0), cv::FILLED);
    double value = -1;
    if (cv::countNonZero(elsewhere) > 0) cv::minMaxLoc(score, nullptr, &value, nullptr, nullptr, elsewhere);
    return value;
  }

  const Sheet& sheet_;
  const FloorScoreOptions& options_;
  cv::Mat map_, truth_, usable_;
  double cell_m_;
  int half_, search_;
};

// ---- All together
// ----------------------------------------------------------------------------------------------------

void DrawPictures(const FloorPicture& map, const FloorPicture& mapped, const TrueFloor& floor, const FloorTruth& extent,
                  const Correlation& fit, const FloorScoreOptions& options, FloorComparison& result) {
  const Sheet sheet(mapped, extent, result.X_WV, options.margin_m);
  if (sheet.empty()) return;
  result.cell_m = map.cell_m;
  result.corner_m = sheet.corner_m();
  const Sheet::DrawnMap shown = sheet.Draw(map, result.X_WV, 1);
  const Sheet::DrawnMap counted = sheet.Draw(mapped, result.X_WV, options.min_sightings);
  const cv::Mat truth = sheet.DrawTruth(floor);
  shown.grey.convertTo(result.estimate, CV_8U);
  result.mask = MaskPicture(shown.sightings);
  cv::Mat drawn = truth.clone();
  drawn.setTo(0, truth != truth);
  drawn.convertTo(result.truth, CV_8U);
  result.difference = DifferencePicture(counted.grey, truth, counted.seen & (truth == truth), fit);
  result.landmarks = LandmarkSearch(sheet, counted.grey, counted.seen, truth, map.cell_m, options).Run();
}

std::vector<double> LandmarkErrors(const std::vector<FloorLandmark>& landmarks) {
  std::vector<double> errors;
  for (const FloorLandmark& l : landmarks) {
    if (l.found) errors.push_back((l.map_m - l.truth_m).norm());
  }
  return errors;
}

/// The map's middle is moved by this when the pictures instead of the trajectories align.
double Shift(const FloorPicture& mapped, const FloorMotion& from, const FloorMotion& to) {
  const Vector2d middle = CellMiddle(mapped, (mapped.intensity.cols - 1) / 2.0, (mapped.intensity.rows - 1) / 2.0);
  return (to * middle - from * middle).norm();
}

}  // namespace

FloorComparison CompareFloor(const FloorPicture& map, const FloorTruth& whole_truth, const Similarity& X_WV,
                             const FloorScoreOptions& options) {
  CheckFields(options, "map.");
  CheckMap(map);
  const FloorPicture mapped = Mapped(map, options.min_sightings);
  FloorComparison result;
  result.X_WV_trajectory = FloorMotion(X_WV);
  const FloorTruth truth = Cropped(whole_truth, mapped, result.X_WV_trajectory, options);
  const TrueFloor floor(truth, map.empty() ? 1 / truth.px_per_m : map.cell_m);
  const Overlap before(mapped, floor, result.X_WV_trajectory);
  const double ncc_before = before.Correlate().Value();
  result.X_WV = AlignFloor(mapped, floor, result.X_WV_trajectory, options.alignment);
  Overlap after(mapped, floor, result.X_WV);
  if (!(after.Correlate().Value() > ncc_before)) {  // the search looked at a part of the cells only
    result.X_WV = result.X_WV_trajectory;
    after = before;
  }
  const Correlation fit = after.Correlate();
  if (!mapped.empty()) DrawPictures(map, mapped, floor, truth, fit, options, result);

  const double cell_m2 = map.cell_m * map.cell_m, on_floor = double(fit.count());
  const int window = map.empty() ? 1 : OddCells(options.local_window_m, map.cell_m);
  const std::vector<double> errors = LandmarkErrors(result.landmarks);
  const double looked_for = double(result.landmarks.size());
  const auto add = [&](const char* name, double value, const char* unit, std::string meaning, Better better) {
    result.scores.push_back({name, value, unit, std::move(meaning), better});
  };
  add("map_ncc", fit.Value(), "", "correlation of mapped and true floor, cell by cell, pictures aligned",
      Better::kHigher);
  add("map_ncc_unaligned", ncc_before, "", "the same where the trajectories' SE(3) alignment puts the map",
      Better::kHigher);
  add("map_ncc_local", after.WithoutLocalMean(window).Correlate().Value(), "",
      fmt::format("the same as map_ncc without each one's mean over {:g} m around: detail alone",
                  options.local_window_m),
      Better::kHigher);
  add("map_area_m2", on_floor * cell_m2, "m2",
      fmt::format("floor that was seen {} times or more often", options.min_sightings), Better::kHigher);
  add("map_outside_ratio", after.mapped > 0 ? 1 - on_floor / double(after.mapped) : kNaN, "",
      "part of the map that lies beyond the true floor's edges", Better::kLower);
  add("map_shift_m", mapped.empty() ? kNaN : Shift(mapped, result.X_WV_trajectory, result.X_WV), "m",
      "how far the pictures' alignment moves the map", Better::kNeither);
  add("map_turn_deg", mapped.empty() ? kNaN : (result.X_WV.yaw - result.X_WV_trajectory.yaw) * 180 / std::numbers::pi,
      "deg", "how far it turns the map to the left", Better::kNeither);
  add("map_landmarks", looked_for, "", "corners of the true floor on mapped ground", Better::kNeither);
  add("map_landmarks_found_ratio", looked_for > 0 ? double(errors.size()) / looked_for : kNaN, "",
      fmt::format("part of them that the map clearly shows within {:g} m", options.landmark_search_m), Better::kHigher);
  add("map_landmark_error_median_m", MedianOf(errors), "m", "how far off the map shows them, median", Better::kLower);
  add("map_landmark_error_p90_m", QuantileOf(errors, 0.9), "m", "how far off the map shows them, 90th percentile",
      Better::kLower);
  return result;
}

}  // namespace gaitcam
