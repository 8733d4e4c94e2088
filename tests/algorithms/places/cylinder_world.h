// A drawn world on a cylinder about the camera, so that what a panorama should show is known: random rectangles of many
// sizes, seen by projection.

#pragma once

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/camera.h"
#include "algorithms/core/random.h"
#include "algorithms/places/panorama.h"

namespace gaitcam {

/// Azimuth over 360 degrees in 2880 columns (8 per degree), tangent of elevation from -1.25 to 1.25 in 1000 rows.
class CylinderWorld {
 public:
  static constexpr int kWidth = 2880, kHeight = 1000;
  static constexpr double kRowsPerTan = 400;

  explicit CylinderWorld(uint64_t seed) : picture(kHeight, kWidth, CV_8UC1, cv::Scalar(120)) {
    RandomStream random(seed, "cylinder_world");
    for (int k = 0; k < 500; ++k) {
      const int width = random.Index(k < 100 ? 500 : 160) + 20, height = random.Index(k < 100 ? 700 : 240) + 20;
      const int x = random.Index(kWidth), y = random.Index(kHeight) - height / 2;
      const cv::Scalar grey(10 + random.Index(230));
      for (const int turn : {0, -kWidth}) cv::rectangle(picture, {x + turn, y, width, height}, grey, cv::FILLED);
    }
    cv::GaussianBlur(picture, picture, {}, 1.5);
  }

  /// Grey value in a direction; `azimuth` left positive.
  double At(double azimuth, double tangent) const {
    const double x = (0.5 - azimuth / (2 * std::numbers::pi)) * kWidth - 0.5;
    const double y = (kHeight - 1) / 2.0 - kRowsPerTan * tangent;
    const double x0 = std::floor(x), y0 = std::min(std::max(std::floor(y), 0.0), kHeight - 2.0);
    const double fx = x - x0, fy = std::min(std::max(y - y0, 0.0), 1.0);
    const int left = ((int(x0) % kWidth) + kWidth) % kWidth, right = (left + 1) % kWidth, top = int(y0);
    return (1 - fy) * ((1 - fx) * picture.at<uchar>(top, left) + fx * picture.at<uchar>(top, right)) +
           fy * ((1 - fx) * picture.at<uchar>(top + 1, left) + fx * picture.at<uchar>(top + 1, right));
  }

  /// What a camera sees that looks to `yaw`. @param up_C as StandingCamera::up_C.
  cv::Mat View(const CameraModel& camera, const Eigen::Vector3d& up_C, double yaw, double gain = 1) const {
    const Eigen::Vector3d up = up_C.normalized(), forward = (Eigen::Vector3d::UnitZ() - up.z() * up).normalized();
    const Eigen::Vector3d left = up.cross(forward);
    cv::Mat view(camera.height_px, camera.width_px, CV_8UC1);
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.cols; ++x) {
        const Eigen::Vector3d ray = camera.Unproject({double(x), double(y)});
        const double ahead = ray.dot(forward), side = ray.dot(left);
        view.at<uchar>(y, x) =
            cv::saturate_cast<uchar>(gain * At(yaw + std::atan2(side, ahead), ray.dot(up) / std::hypot(ahead, side)));
      }
    }
    return view;
  }

  /// The panorama as it should be.
  cv::Mat Panorama(const PanoramaLayout& layout) const {
    cv::Mat panorama(layout.height_px, layout.width_px, CV_8UC1);
    for (int y = 0; y < panorama.rows; ++y) {
      for (int x = 0; x < panorama.cols; ++x)
        panorama.at<uchar>(y, x) = cv::saturate_cast<uchar>(At(layout.AzimuthOf(x), layout.TanElevationOf(y)));
    }
    return panorama;
  }

  cv::Mat picture;
};

/// The ERS-7's: 208 x 160 px, 56.9 x 45.2 degrees.
inline CameraModel Ers7Camera() { return CameraModel::FromHorizontalFov(208, 160, 56.9); }

/// Up in the frame of a camera that looks down by so much.
inline Eigen::Vector3d UpOf(double pitch_deg) {
  const double pitch = pitch_deg * std::numbers::pi / 180;
  return {0, -std::cos(pitch), -std::sin(pitch)};
}

}  // namespace gaitcam
