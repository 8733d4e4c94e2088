// A textured room filmed along a known path, in plain OpenCV: what the tests of algorithms use instead of a simulator.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/random.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

// Overlapping discs of all sizes (dead leaves): edges and corners at every scale, as in natural images. With its
// pyramid.
inline std::vector<cv::Mat> DeadLeaves(int size_px, uint64_t seed, const std::string& name) {
  RandomStream random(seed, name);
  cv::Mat image(size_px, size_px, CV_8UC1, cv::Scalar(128));
  const int leaves = size_px * size_px / 120;
  for (int i = 0; i < leaves; ++i) {
    const double radius = std::min(2.0 / std::sqrt(random.Uniform(1e-4, 1.0)), size_px / 12.0);
    const cv::Point centre(random.Index(size_px), random.Index(size_px));
    const cv::Scalar grey(random.Uniform(20, 235));
    if (random.Uniform() < 0.5) {
      cv::circle(image, centre, int(radius) + 1, grey, cv::FILLED);
    } else {
      const cv::Point half(int(radius * random.Uniform(0.5, 1.5)) + 1, int(radius) + 1);
      cv::rectangle(image, centre - half, centre + half, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.7);
  std::vector<cv::Mat> pyramid = {image};
  while (pyramid.back().cols > 16) {
    cv::Mat half;
    cv::pyrDown(pyramid.back(), half);
    pyramid.push_back(half);
  }
  return pyramid;
}

// A box-shaped room around the origin: floor at z = 0, ceiling at 2.4 m, four walls 3 m away, all textured.
class SyntheticScene {
 public:
  explicit SyntheticScene(uint64_t seed, double texel_m = 0.004) : texel_m_(texel_m) {
    for (size_t face = 0; face < faces_.size(); ++face) {
      faces_[face] = DeadLeaves(int(2 * kHalf / texel_m), seed, "face" + std::to_string(face));
    }
  }

  // One instant, one ray per pixel, `shift_px` from its centre; each takes the texture at the resolution of its
  // footprint.
  cv::Mat Render(const CameraModel& camera, const Pose& X_WC, const Eigen::Vector2d& shift_px) const {
    return RenderRows(
        camera, [&](int) { return X_WC; }, shift_px);
  }

  // The same, each row v from a pose of its own.
  template <class PoseOfRow>
  cv::Mat RenderRows(const CameraModel& camera, PoseOfRow pose, const Eigen::Vector2d& shift_px) const {
    cv::Mat image(camera.height_px, camera.width_px, CV_32FC1);
    for (int v = 0; v < camera.height_px; ++v) {
      const Pose X_WC = pose(v);
      const Eigen::Matrix3d R = X_WC.R();
      for (int u = 0; u < camera.width_px; ++u) {
        const Eigen::Vector3d ray = R * camera.Unproject(Eigen::Vector2d(u, v) + shift_px);
        image.at<float>(v, u) = float(Shade(X_WC.translation, ray, camera.fx));
      }
    }
    return image;
  }

  // Depth along the optical axis at the pixels' centres.
  cv::Mat Depth(const CameraModel& camera, const Pose& X_WC) const {
    cv::Mat depth(camera.height_px, camera.width_px, CV_32FC1);
    for (int v = 0; v < depth.rows; ++v) {
      for (int u = 0; u < depth.cols; ++u) {
        depth.at<float>(v, u) =
            float(Hit(X_WC.translation, X_WC.R() * camera.Unproject({double(u), double(v)})).second);
      }
    }
    return depth;
  }

 private:
  static constexpr double kHalf = 3, kHeight = 2.4;

  // Face and length of the ray, in units of its direction (which has z = 1 in the camera's frame).
  static std::pair<int, double> Hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
    int face = 0;
    double nearest = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double high = axis == 2 ? kHeight : kHalf, low = axis == 2 ? 0 : -kHalf;
      const double t = ((ray[axis] > 0 ? high : low) - origin[axis]) / (ray[axis] == 0 ? 1e-12 : ray[axis]);
      if (t > 0 && t < nearest) {
        nearest = t;
        face = 2 * axis + (ray[axis] > 0);
      }
    }
    return {face, nearest};
  }

  double Shade(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, double focal_px) const {
    const auto [face, t] = Hit(origin, ray);
    const Eigen::Vector3d p = origin + t * ray;
    const int axis = face / 2;
    const double a = (axis == 0 ? p.y() : p.x()) + kHalf, b = (axis == 2 ? p.y() : p.z()) + (axis == 2 ? kHalf : 0);
    const double slant = std::max(std::abs(ray[axis]) / ray.norm(), 0.15);
    const double footprint = t * ray.norm() / focal_px / texel_m_ / std::sqrt(slant);  // texels per pixel
    const int level = std::clamp(int(std::lround(std::log2(std::max(footprint, 1.0)))), 0, int(faces_[0].size()) - 1);
    const cv::Mat& texture = faces_[size_t(face)][size_t(level)];
    const double scale = 1.0 / (texel_m_ * (1 << level));
    return Bilinear(texture, a * scale, b * scale);
  }

  static double Bilinear(const cv::Mat& image, double x, double y) {
    x = std::clamp(x, 0.0, image.cols - 1.001);
    y = std::clamp(y, 0.0, image.rows - 1.001);
    const int x0 = int(x), y0 = int(y);
    const double fx = x - x0, fy = y - y0;
    const uchar *top = image.ptr(y0) + x0, *bottom = image.ptr(y0 + 1) + x0;
    return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) + fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
  }

  double texel_m_;
  std::array<std::vector<cv::Mat>, 6> faces_;
};

// Optical axis along the world's x axis (forward), then turned: yaw to the left, pitch up, roll clockwise as seen.
inline Pose LookingForward(const Eigen::Vector3d& position, double yaw, double pitch, double roll) {
  Eigen::Matrix3d R_forward;
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {RotZ(yaw) * RotY(-pitch) * RotX(roll) * R_forward, position};
}

// A small humanoid's head on a straight walk: 10 cm/s, 0.35 m high, swaying once and nodding twice per double step.
inline Pose WalkPose(double t_s, double sway = 1.0) {
  const double w = 2 * M_PI * 1.43;
  const Eigen::Vector3d position(-1.2 + 0.10 * t_s + sway * 0.003 * std::sin(2 * w * t_s),
                                 sway * 0.012 * std::sin(w * t_s), 0.35 + sway * 0.003 * std::cos(2 * w * t_s));
  const double roll = sway * 0.042 * std::sin(w * t_s + 0.3), pitch = -0.25 + sway * 0.023 * std::sin(2 * w * t_s);
  return LookingForward(position, sway * 0.017 * std::sin(w * t_s + 1.1), pitch, roll);
}

struct Film {
  std::vector<Observation> frames;
  Trajectory truth;
};

// Films along `pose(t)` at 30 Hz: `subframes` instants spread over the exposure are averaged, each looking elsewhere
// within the pixels, then noise and 8 bit.
template <class PoseOfTime>
Film FilmPath(const SyntheticScene& scene, const CameraModel& camera, int frames, PoseOfTime pose,
              double exposure_ms = 10, int subframes = 4, double noise_grey = 1.5) {
  Film film;
  RandomStream random(7, "film");
  for (int k = 0; k < frames; ++k) {
    const int64_t stamp_ns = 1'000'000'000 + int64_t(k) * 33'333'333;
    const double t = double(stamp_ns - 1'000'000'000) * 1e-9;
    cv::Mat sum = cv::Mat::zeros(camera.height_px, camera.width_px, CV_32FC1);
    for (int i = 0; i < subframes; ++i) {
      const Pose X_WC = pose(t + 1e-3 * exposure_ms * ((i + 0.5) / subframes - 0.5));
      sum +=
          scene.Render(camera, X_WC, {i % 2 - 0.5 < 0 ? -0.25 : 0.25, (i + i / 2) % 2 == 0 ? -0.25 : 0.25}) / subframes;
    }
    for (float& grey : cv::Mat_<float>(sum)) grey += float(random.Normal(0, noise_grey));
    Observation observation;
    observation.stamp_ns = observation.image.stamp_ns = stamp_ns;
    observation.exposure_ms = exposure_ms;
    sum.convertTo(observation.image.pixels, CV_8UC1);
    film.frames.push_back(observation);
    film.truth.push_back({stamp_ns, pose(t)});
  }
  return film;
}

}  // namespace gaitcam
