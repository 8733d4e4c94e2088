#include "results/scoring/floor_landmarks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "results/scoring/floor_overlap.h"

namespace gaitcam::internal {
namespace {

using Eigen::Vector2d;

/// Vertex of the parabola through three values at -1, 0, 1; the middle one is the largest.
double Top(double before, double middle, double after) {
  const double bend = before - 2 * middle + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

}  // namespace

FloorLandmarkSearch::FloorLandmarkSearch(const FloorSheet& sheet, const cv::Mat& map, const cv::Mat& seen,
                                         const cv::Mat& truth, const FloorScoreOptions& options)
    : sheet_(sheet), options_(options), map_(map.clone()), truth_(truth.clone()) {
  const double cell_m = sheet.cell_m();
  half_ = OddCells(options.landmark_patch_m, cell_m) / 2;
  search_ = std::max(1, int(std::lround(options.landmark_search_m / cell_m)));
  const cv::Mat floor = truth == truth;
  truth_.setTo(0, ~floor);
  // Small holes of the map are filled with the local mean, so that they add no structure.
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

std::vector<FloorLandmark> FloorLandmarkSearch::Run() const {
  std::vector<cv::Point2f> corners;
  if (cv::countNonZero(usable_) > 0) {
    cv::goodFeaturesToTrack(truth_, corners, 0, options_.landmark_quality,
                            options_.landmark_spacing_m / sheet_.cell_m(), usable_);
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

/// Position of the true patch around `at` in the map, with sub-pixel precision; nothing without one clear peak.
std::optional<Vector2d> FloorLandmarkSearch::Find(cv::Point at) const {
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

/// The maximum outside the peak's own neighbourhood, whose radius is half of the patch.
double FloorLandmarkSearch::BestElsewhere(const cv::Mat& score, cv::Point best) const {
  cv::Mat elsewhere(score.size(), CV_8UC1, cv::Scalar(255));
  cv::circle(elsewhere, best, half_, cv::Scalar(0), cv::FILLED);
  double value = -1;
  if (cv::countNonZero(elsewhere) > 0) cv::minMaxLoc(score, nullptr, &value, nullptr, nullptr, elsewhere);
  return value;
}

}  // namespace gaitcam::internal
