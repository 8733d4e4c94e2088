#include "algorithms/planes/undistortion.h"

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

Undistortion::Undistortion(const CameraModel& lens) : camera_(WithoutDistortion(lens)) {
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

cv::Mat Undistortion::Grey(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  cv::Mat grey = image, straight;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (map_u_.empty()) return grey;
  cv::remap(grey, straight, map_u_, map_v_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return straight;
}

}  // namespace gaitcam
