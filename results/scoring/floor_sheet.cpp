#include "results/scoring/floor_sheet.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace gaitcam::internal {

using Eigen::Vector2d;

FloorSheet::FloorSheet(const FloorPicture& map, const FloorTruth& floor, const FloorMotion& X_WV, double margin_m)
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

FloorSheet::DrawnMap FloorSheet::Draw(const FloorPicture& map, const FloorMotion& X_WV, int min_sightings) const {
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

cv::Mat FloorSheet::DrawTruth(const TrueFloor& floor) const {
  cv::Mat truth(size_, CV_32FC1);
  for (int v = 0; v < size_.height; ++v) {
    for (int u = 0; u < size_.width; ++u) truth.at<float>(v, u) = floor.Mean(Middle(u, v), 0);
  }
  return truth;
}

cv::Mat MaskPicture(const cv::Mat& sightings) {
  cv::Mat mask;
  sightings.convertTo(mask, CV_32F);
  cv::log(mask + 1, mask);
  double max = 0;
  cv::minMaxLoc(mask, nullptr, &max);
  mask.convertTo(mask, CV_8U, max > 0 ? 255 / max : 0);
  return mask;
}

cv::Mat DifferencePicture(const cv::Mat& map, const cv::Mat& truth, const cv::Mat& both, const Correlation& fit,
                          double full_scale_grey) {
  constexpr int kNothing = 40;  // grey of what cannot be compared
  cv::Mat picture(map.size(), CV_8UC3, cv::Scalar::all(kNothing));
  const bool known = !std::isnan(fit.Gain());
  for (int v = 0; v < map.rows && known; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (!both.at<uchar>(v, u)) continue;
      const double e = fit.Gain() * map.at<float>(v, u) + fit.Offset() - truth.at<float>(v, u);
      const uchar rest = cv::saturate_cast<uchar>(255 * (1 - std::abs(e) / full_scale_grey));
      picture.at<cv::Vec3b>(v, u) = e > 0 ? cv::Vec3b(rest, rest, 255) : cv::Vec3b(255, rest, rest);
    }
  }
  return picture;
}

}  // namespace gaitcam::internal
