#include "algorithms/planes/undistortion.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

CameraModel WithoutDistortion(CameraModel camera) {
  camera.k1 = camera.k2 = camera.k3 = camera.p1 = camera.p2 = 0;
  return camera;
}

}  // namespace

Undistortion::Undistortion(const CameraModel& lens) : lens_(lens), camera_(WithoutDistortion(lens)) {
  if (!lens.IsDistorted()) return;
  map_u_.create(lens.height_px, lens.width_px, CV_32FC1);
  map_v_.create(lens.height_px, lens.width_px, CV_32FC1);
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const Eigen::Vector2d p = *lens.Project(camera_.Unproject({double(u), double(v)}));
      map_u_.at<float>(v, u) = float(p.x());
      map_v_.at<float>(v, u) = float(p.y());
    }
  }
}

/// Maps as map_u_ and map_v_: computed on a grid and interpolated, as they are smooth.
void Undistortion::MapRolling(const SeenAtRow& seen, cv::Mat& map_u, cv::Mat& map_v) const {
  constexpr int kGrid_px = 4;
  constexpr int kIterations = 3;  // which row it was depends on where it was seen; a turn moves that by a few rows
  const double last_row = camera_.height_px - 1.0;
  cv::Mat grid((camera_.height_px - 1) / kGrid_px + 2, (camera_.width_px - 1) / kGrid_px + 2, CV_32FC2);
  for (int i = 0; i < grid.rows; ++i) {
    for (int j = 0; j < grid.cols; ++j) {
      Eigen::Vector2d at(j * kGrid_px, i * kGrid_px);
      const Eigen::Vector3d ray_S = camera_.Unproject(at);
      for (int k = 0; k < kIterations; ++k) {
        const double row = last_row > 0 ? std::clamp(at.y() / last_row, 0.0, 1.0) : 0.5;
        at = lens_.Project(seen(ray_S, row)).value_or(at);
      }
      grid.at<cv::Vec2f>(i, j) = {float(at.x()), float(at.y())};
    }
  }
  const cv::Matx23d to_grid(1.0 / kGrid_px, 0, 0, 0, 1.0 / kGrid_px, 0);
  cv::Mat both;
  cv::warpAffine(grid, both, to_grid, {camera_.width_px, camera_.height_px}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  cv::extractChannel(both, map_u, 0);
  cv::extractChannel(both, map_v, 1);
}

cv::Mat Undistortion::Grey(const cv::Mat& image, const SeenAtRow& seen) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  cv::Mat grey = image, straight;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat map_u = map_u_, map_v = map_v_;
  if (seen) MapRolling(seen, map_u, map_v);
  if (map_u.empty()) return grey;
  cv::remap(grey, straight, map_u, map_v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return straight;
}

}  // namespace gaitcam
