#include "results/scoring/floor_overlap.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/units.h"

namespace gaitcam::internal {
namespace {

using Eigen::Vector2d;

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

}  // namespace

FloorPicture WellSeen(const FloorPicture& map, int min_sightings) {
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

FloorTruth CroppedTo(const FloorPicture& map, const FloorTruth& truth, const FloorMotion& X_WV, double margin_m,
                     const FloorAlignmentOptions& limits) {
  if (map.empty() || truth.grey.empty() || !(truth.px_per_m > 0)) return truth;
  const cv::Size size = map.intensity.size();
  const double diagonal = map.cell_m * std::hypot(size.width, size.height);
  // A turn moves no cell further than it would at the other end of the diagonal.
  const double reach = diagonal / 2 + margin_m + 2 * limits.max_shift_m + diagonal * limits.max_turn_deg * kPi / 180;
  const Vector2d middle = X_WV * CellMiddle(map, (size.width - 1) / 2.0, (size.height - 1) / 2.0);
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

FloorOverlap::FloorOverlap(const FloorPicture& picture, const TrueFloor& floor, const FloorMotion& X_WV) {
  if (picture.empty()) return;
  picture.intensity.convertTo(map, CV_32F);
  truth = TruthAtCells(picture, floor, X_WV);
  both = truth == truth;  // not NaN
  truth.setTo(0, ~both);
  mapped = cv::countNonZero(picture.sightings);
}

Correlation FloorOverlap::Correlate() const {
  Correlation correlation;
  for (int v = 0; v < both.rows; ++v) {
    for (int u = 0; u < both.cols; ++u) {
      if (both.at<uchar>(v, u)) correlation.Add(map.at<float>(v, u), truth.at<float>(v, u));
    }
  }
  return correlation;
}

FloorOverlap FloorOverlap::WithoutLocalMean(int window) const {
  FloorOverlap local = *this;
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

int OddCells(double side_m, double cell_m) { return 2 * std::max(1, int(std::lround(side_m / cell_m / 2))) + 1; }

}  // namespace gaitcam::internal
