#include "sim/camera/blur_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

constexpr double kInfinitely = 1e6;  // m; far enough that no motion of the camera shows

/// A relative motion in single precision, and the pinhole part of the projection.
struct Mover {
  Eigen::Matrix3f R = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t = Eigen::Vector3f::Zero();

  Mover() = default;
  explicit Mover(const Pose& X) : R(X.R().cast<float>()), t(X.translation.cast<float>()) {}
};

Eigen::Vector2f Project(const CameraModel& camera, bool distorted, const Eigen::Vector3f& p) {
  if (!(p.z() > 0)) return Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
  const Eigen::Vector2f ideal(p.x() / p.z(), p.y() / p.z());
  if (!distorted) return {float(camera.fx) * ideal.x(), float(camera.fy) * ideal.y()};
  const Eigen::Vector2d bent = camera.Distort(ideal.cast<double>());
  return {float(camera.fx * bent.x()), float(camera.fy * bent.y())};
}

}  // namespace

SceneInstant CaptureInstant(const mjModel* model, const mjData& data, int camera_id, int64_t stamp_ns,
                            bool with_people) {
  SceneInstant instant;
  instant.stamp_ns = stamp_ns;
  instant.X_WC = CameraPose(data, camera_id);
  instant.X_WB.resize(size_t(model->nbody));
  const int end = with_people ? model->nbody : FirstPersonBody(model);
  for (int body = 0; body < end; ++body) {
    const mjtNum* q = data.xquat + ptrdiff_t{4} * body;
    instant.X_WB[size_t(body)] = Pose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
                                      Eigen::Map<const Eigen::Vector3d>(data.xpos + ptrdiff_t{3} * body));
  }
  return instant;
}

std::vector<int> SeenBodies(const cv::Mat& bodies) {
  if (bodies.empty()) return {0};
  std::vector<int> seen;
  int before = -1;
  for (int row = 0; row < bodies.rows; ++row) {
    for (int col = 0; col < bodies.cols; ++col) {
      const int body = bodies.at<int>(row, col);
      if (body != before) seen.push_back(body);
      before = body;
    }
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  return seen;
}

void PoseSeenPeople(const mjModel* model, const std::vector<PersonWalk>& people, std::span<const int> seen,
                    SceneInstant& instant) {
  const int first = FirstPersonBody(model);
  int posed = -1;
  PersonPose pose;
  for (const int body : seen) {
    if (body < first) continue;
    const int person = (body - first) / kPersonParts;
    if (person != posed) pose = people[size_t(person)].At(1e-9 * double(instant.stamp_ns));
    posed = person;
    instant.X_WB[size_t(body)] = pose[size_t((body - first) % kPersonParts)];
  }
}

Pose RelativeMotion(const SceneInstant& from, const SceneInstant& to, int body) {
  return to.X_WC.Inverse() * to.X_WB[body] * from.X_WB[body].Inverse() * from.X_WC;
}

SeenPoints::SeenPoints(const cv::Mat& rays, const cv::Mat& depth, const cv::Mat& bodies, const SceneInstant& at,
                       int stride)
    : seen_at_(at) {
  GAITCAM_ASSERT(rays.type() == CV_32FC2 && depth.type() == CV_32FC1 && rays.size() == depth.size() && stride >= 1);
  const auto picks = [stride](int count) {
    std::vector<int> indices;
    for (int i = 0; i < count - 1; i += stride) indices.push_back(i);
    indices.push_back(count - 1);
    return indices;
  };
  for (const int row : picks(rays.rows)) {
    for (const int col : picks(rays.cols)) {
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(row, col);
      const float z = depth.at<float>(row, col);
      p_C_.push_back(Eigen::Vector3d(ray[0], ray[1], 1) * (z > 0 ? double(z) : kInfinitely));
      body_.push_back(bodies.empty() ? 0 : bodies.at<int>(row, col));
    }
  }
}

std::vector<Eigen::Vector2d> SeenPoints::Project(const CameraModel& camera, const SceneInstant& at) const {
  std::vector<Pose> motion(at.X_WB.size());
  std::vector<char> known(at.X_WB.size(), 0);
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(p_C_.size());
  for (size_t i = 0; i < p_C_.size(); ++i) {
    const int body = body_[i];
    if (!known[body]) {
      motion[body] = RelativeMotion(seen_at_, at, body);
      known[body] = 1;
    }
    const auto pixel = camera.Project(motion[body] * p_C_[i]);
    pixels.push_back(pixel.value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN())));
  }
  return pixels;
}

cv::Mat BlurVectors(const CameraModel& camera, const cv::Mat& rays, const cv::Mat& depth, const cv::Mat& bodies,
                    const SceneInstant& middle, const std::vector<std::pair<SceneInstant, SceneInstant>>& bands) {
  GAITCAM_ASSERT(!bands.empty() && rays.size() == depth.size());
  const bool distorted = camera.IsDistorted();
  cv::Mat vectors(rays.size(), CV_32FC2);
  size_t current = bands.size();
  const std::vector<int> seen = SeenBodies(bodies);
  std::vector<std::pair<Mover, Mover>> movers(middle.X_WB.size());
  for (int row = 0; row < rays.rows; ++row) {
    const size_t band = size_t(row) * bands.size() / size_t(rays.rows);
    if (band != current) {
      current = band;
      for (const int body : seen) {
        movers[size_t(body)] = {Mover(RelativeMotion(middle, bands[band].first, body)),
                                Mover(RelativeMotion(middle, bands[band].second, body))};
      }
    }
    for (int col = 0; col < rays.cols; ++col) {
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(row, col);
      const float z = depth.at<float>(row, col);
      const auto& [open, close] = movers[bodies.empty() ? 0 : bodies.at<int>(row, col)];
      const Eigen::Vector3f p = Eigen::Vector3f(ray[0], ray[1], 1) * (z > 0 ? z : float(kInfinitely));
      const Eigen::Vector2f moved =
          Project(camera, distorted, close.R * p + close.t) - Project(camera, distorted, open.R * p + open.t);
      vectors.at<cv::Vec2f>(row, col) = {moved.x(), moved.y()};
    }
  }
  return vectors;
}

PathLengths MeasurePaths(const CameraModel& camera, const SeenPoints& points,
                         const std::vector<SceneInstant>& instants) {
  std::vector<double> lengths(points.size(), 0);
  std::vector<Eigen::Vector2d> before;
  for (const SceneInstant& instant : instants) {
    std::vector<Eigen::Vector2d> now = points.Project(camera, instant);
    for (size_t i = 0; i < before.size(); ++i) lengths[i] += (now[i] - before[i]).norm();
    before = std::move(now);
  }
  std::erase_if(lengths, [](double length) { return !std::isfinite(length); });
  if (lengths.empty()) return {};
  std::sort(lengths.begin(), lengths.end());
  const auto quantile = [&](double q) { return lengths[size_t(std::lround(q * double(lengths.size() - 1)))]; };
  return {quantile(0.5), quantile(0.9), lengths.back()};
}

}  // namespace gaitcam
