/// Images of a floor of known texture by an ideal camera at known poses.

#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/random.h"

namespace gaitcam {

/// Waves of random directions and phases, so that no position looks like another.
class DrawnFloor {
 public:
  /// @param min_wave_m the shortest of the waves, whose longest is 50 cm: no shorter than what the camera resolves.
  explicit DrawnFloor(uint64_t seed, double min_wave_m = 0.06) {
    RandomStream random(seed, "floor");
    for (int i = 0; i < 14; ++i) {
      const double length_m = std::exp(random.Uniform(std::log(min_wave_m), std::log(0.5)));
      const double angle = random.Uniform(0, 2 * std::numbers::pi), phase = random.Uniform(0, 2 * std::numbers::pi);
      waves_.push_back({2 * std::numbers::pi / length_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)), phase});
    }
  }
  double At(const Eigen::Vector2d& p) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += std::cos(wave.k.dot(p) + wave.phase);
    return 128 + 80 * std::tanh(sum / 3);
  }

 private:
  struct Wave {
    Eigen::Vector2d k;
    double phase;
  };
  std::vector<Wave> waves_;
};

inline CameraModel SmallCamera() { return CameraModel::FromHorizontalFov(160, 120, 65); }

constexpr double kDrawnHeight_m = 0.3, kDrawnPitch_rad = 0.75;

/// A camera `height_m` above the floor, looking ahead and down.
inline Pose CameraOver(const PlanarPose& below, double height_m = kDrawnHeight_m, double pitch_rad = kDrawnPitch_rad,
                       double roll_rad = 0) {
  const Eigen::Matrix3d level = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  const Pose X_WP = below.Lifted();
  return {X_WP.R() * RotX(roll_rad) * RotY(pitch_rad) * level, X_WP.translation + Eigen::Vector3d(0, 0, height_m)};
}

inline Calibration DrawnCalibration() {
  Calibration calibration;
  calibration.camera = SmallCamera();
  calibration.frame_rate_hz = 30;
  const Pose X_WC = CameraOver({});
  calibration.standing = StandingCamera{kDrawnHeight_m, X_WC.R().transpose() * Eigen::Vector3d::UnitZ()};
  return calibration;
}

/// Grey level where something else than the floor is visible along a ray from X_WC, or nothing.
using Obstacle = std::function<std::optional<double>(const Pose& X_WC, const Eigen::Vector3d& ray_W)>;

struct DrawOptions {
  CameraModel camera = SmallCamera();
  double noise_grey = 0;  ///< Standard deviation.
  uint64_t seed = 1;      ///< Of the noise.
  int samples = 1;        ///< Per pixel, along each side.
  Obstacle obstacle = {};
};

/// Grey level of one ray; sky, and floor farther than 6 m, is 128.
inline double Shade(const DrawnFloor& floor, const Pose& X_WC, const Eigen::Vector3d& ray, const Obstacle& obstacle) {
  const double distance = ray.z() < 0 ? -X_WC.translation.z() / ray.z() : 1e9;
  const std::optional<double> other = obstacle ? obstacle(X_WC, ray) : std::nullopt;
  return other ? *other : distance > 6 ? 128 : floor.At((X_WC.translation + distance * ray).head<2>());
}

/// Mean over the poses of an exposure. CV_8UC1.
inline cv::Mat Draw(const DrawnFloor& floor, const std::vector<Pose>& exposure, const DrawOptions& options) {
  RandomStream random(options.seed, "noise");
  const CameraModel& camera = options.camera;
  const int n = options.samples;
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double sum = 0;
      for (int sample = 0; sample < n * n; ++sample) {
        const Eigen::Vector2d pixel(u + (sample % n + 0.5) / n - 0.5, v + (sample / n + 0.5) / n - 0.5);
        const Eigen::Vector3d ray_C = camera.Unproject(pixel);
        for (const Pose& X_WC : exposure) sum += Shade(floor, X_WC, X_WC.rotation * ray_C, options.obstacle);
      }
      const double mean = sum / (n * n * double(exposure.size()));
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(mean + options.noise_grey * random.Normal());
    }
  }
  return image;
}

inline cv::Mat Draw(const DrawnFloor& floor, const std::vector<Pose>& exposure, double noise_grey = 0,
                    uint64_t seed = 1, const Obstacle& obstacle = nullptr) {
  return Draw(floor, exposure, DrawOptions{SmallCamera(), noise_grey, seed, 1, obstacle});
}

/// By a rolling shutter, without blur.
/// @param at pose at a time after the stamp, s; the row in the middle is exposed at 0
template <class PoseAt>
cv::Mat DrawRolling(const DrawnFloor& floor, const PoseAt& at, double readout_s) {
  const CameraModel camera = SmallCamera();
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    const Pose X_WC = at(readout_s * (v / (image.rows - 1.0) - 0.5));
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector3d ray = X_WC.rotation * camera.Unproject({double(u), double(v)});
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(Shade(floor, X_WC, ray, {}));
    }
  }
  return image;
}

inline Observation Observe(const cv::Mat& image, int frame, double exposure_ms = 0) {
  Observation observation;
  observation.stamp_ns = 1'000'000'000 + frame * 33'333'333LL;
  observation.exposure_ms = exposure_ms;
  observation.image = {observation.stamp_ns, image};
  return observation;
}

}  // namespace gaitcam
