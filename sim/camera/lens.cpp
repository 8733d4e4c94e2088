#include "sim/camera/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

[[noreturn]] void ThrowFolded(int u, int v) {
  throw BadOption("camera distortion: no single ray leads to pixel (" + std::to_string(u) + ", " + std::to_string(v) +
                  "); expected smaller k1, k2, k3, p1, p2 or a narrower field of view");
}

/// Rays of all pixels, or BadOption where the distortion has no inverse.
cv::Mat PixelRays(const CameraModel& camera) {
  cv::Mat rays(camera.height_px, camera.width_px, CV_32FC2);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const Eigen::Vector2d pixel(u, v);
      const Eigen::Vector3d ray = camera.Unproject(pixel);
      const auto back = camera.Project(ray);
      if (!ray.allFinite() || !back || (*back - pixel).norm() > 1e-6) ThrowFolded(u, v);
      rays.at<cv::Vec2f>(v, u) = {float(ray.x()), float(ray.y())};
      // Beyond its turning point the distortion maps back onto the same pixels: radius then decreases with the angle.
      if (u > 0 && rays.at<cv::Vec2f>(v, u)[0] <= rays.at<cv::Vec2f>(v, u - 1)[0]) ThrowFolded(u, v);
      if (v > 0 && rays.at<cv::Vec2f>(v, u)[1] <= rays.at<cv::Vec2f>(v - 1, u)[1]) ThrowFolded(u, v);
    }
  }
  return rays;
}

/// Largest local magnification of the ideal picture that the camera makes anywhere, so that the warp loses no detail.
double LargestScale(const CameraModel& camera, const cv::Mat& rays) {
  double scale = 0;
  for (int v = 0; v < rays.rows; v += std::max(1, rays.rows - 1) / 8 + 1) {
    for (int u = 0; u + 1 < rays.cols; u += std::max(1, rays.cols - 1) / 8 + 1) {
      const cv::Vec2f step = rays.at<cv::Vec2f>(v, u + 1) - rays.at<cv::Vec2f>(v, u);
      scale = std::max(scale, 1 / double(std::hypot(step[0], step[1])));
    }
  }
  return std::max({scale, camera.fx, camera.fy});
}

/// An ideal camera of focal length f whose picture covers all rays with `margin` pixels to spare on each side.
CameraModel CoveringPinhole(const cv::Mat& rays, double f, int margin) {
  double left = std::numeric_limits<double>::max(), top = left, right = -left, bottom = -left;
  for (int v = 0; v < rays.rows; ++v) {
    for (int u = 0; u < rays.cols; ++u) {
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(v, u);
      left = std::min(left, double(ray[0]));
      right = std::max(right, double(ray[0]));
      top = std::min(top, double(ray[1]));
      bottom = std::max(bottom, double(ray[1]));
    }
  }
  CameraModel pinhole;
  pinhole.fx = pinhole.fy = f;
  pinhole.cx = std::ceil(-left * f) + margin;
  pinhole.cy = std::ceil(-top * f) + margin;
  pinhole.width_px = int(std::ceil(right * f + pinhole.cx)) + 1 + margin;
  pinhole.height_px = int(std::ceil(bottom * f + pinhole.cy)) + 1 + margin;
  return pinhole;
}

float Reciprocal(float nearness) { return nearness > 0 ? 1 / nearness : 0; }

/// Depth at a point between four pixels.
float DepthBetween(const cv::Mat& nearness, float at_x, float at_y) {
  constexpr float kEdgeRatio = 1.05f;  // neighbours whose depths differ by more lie on different surfaces
  const int x = int(at_x), y = int(at_y);
  const float s = at_x - float(x), t = at_y - float(y);
  const float* upper = nearness.ptr<float>(y) + x;
  const float* lower = nearness.ptr<float>(y + 1) + x;
  const float least = std::min({upper[0], upper[1], lower[0], lower[1]});
  const float most = std::max({upper[0], upper[1], lower[0], lower[1]});
  if (least <= 0 || most > kEdgeRatio * least) return Reciprocal((t >= 0.5f ? lower : upper)[s >= 0.5f ? 1 : 0]);
  return 1 / ((1 - t) * ((1 - s) * upper[0] + s * upper[1]) + t * ((1 - s) * lower[0] + s * lower[1]));
}

}  // namespace

Lens::Lens(const CameraModel& camera) : camera_(camera), pinhole_(camera) {
  camera.Check();
  rays_ = PixelRays(camera);
  warps_ = camera.IsDistorted() || camera.fx != camera.fy;
  if (!warps_) return;
  pinhole_ = CoveringPinhole(rays_, LargestScale(camera, rays_), 2);
  if (pinhole_.width_px > 4 * camera.width_px || pinhole_.height_px > 4 * camera.height_px) {
    throw BadOption("camera distortion: an undistorted picture would have " + std::to_string(pinhole_.width_px) +
                    " x " + std::to_string(pinhole_.height_px) + " px; expected at most four times the image's size");
  }
  map_.create(rays_.size(), CV_32FC2);
  for (int v = 0; v < rays_.rows; ++v) {
    for (int u = 0; u < rays_.cols; ++u) {
      const cv::Vec2f ray = rays_.at<cv::Vec2f>(v, u);
      map_.at<cv::Vec2f>(v, u) = {float(pinhole_.fx * ray[0] + pinhole_.cx), float(pinhole_.fy * ray[1] + pinhole_.cy)};
    }
  }
}

cv::Mat Lens::Depth(const cv::Mat& nearness) const {
  if (warps_) return Depth(nearness, pinhole_);
  GAITCAM_ASSERT(nearness.type() == CV_32FC1 && nearness.size() == rays_.size());
  cv::Mat depth(nearness.size(), CV_32FC1);
  std::transform(nearness.begin<float>(), nearness.end<float>(), depth.begin<float>(), Reciprocal);
  return depth;
}

cv::Mat Lens::Depth(const cv::Mat& nearness, const CameraModel& picture) const {
  GAITCAM_ASSERT(nearness.type() == CV_32FC1 && nearness.size() == cv::Size(picture.width_px, picture.height_px));
  const float f = float(picture.fx), cx = float(picture.cx), cy = float(picture.cy);
  cv::Mat depth(rays_.size(), CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    const cv::Vec2f* rays = rays_.ptr<cv::Vec2f>(v);
    float* to = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) to[u] = DepthBetween(nearness, f * rays[u][0] + cx, f * rays[u][1] + cy);
  }
  return depth;
}

cv::Mat Lens::WarpLabels(const cv::Mat& labels) const {
  GAITCAM_ASSERT(labels.type() == CV_32SC1);
  if (!warps_) return labels;
  cv::Mat warped(rays_.size(), CV_32SC1);
  for (int v = 0; v < warped.rows; ++v) {
    for (int u = 0; u < warped.cols; ++u) {
      const cv::Vec2f at = map_.at<cv::Vec2f>(v, u);
      warped.at<int>(v, u) = labels.at<int>(int(std::lround(at[1])), int(std::lround(at[0])));
    }
  }
  return warped;
}

}  // namespace gaitcam
