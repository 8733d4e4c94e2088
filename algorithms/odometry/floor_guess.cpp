#include "algorithms/odometry/floor_guess.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "algorithms/geometry/ransac.h"

namespace gaitcam {
namespace {

constexpr int kFewestInliers = 40;        // a plane that fewer points lie on may be anything
constexpr double kSteepest = 0.82;        // cosine of the largest angle between normal and the camera's up: 35 degrees
constexpr double kThickness = 0.06;       // of the floor, part of the camera's height
constexpr double kHeightSpread = 0.06;    // how much a walking camera's height varies, part of it
constexpr double kTiltSpread_rad = 0.02;  // how well the normal is known
constexpr int kLately = 5;                // keyframes

using Plane = FloorPlane;

std::optional<Plane> Through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Plane plane;
  plane.normal = (b - a).cross(c - a).normalized();
  if (!plane.normal.allFinite()) return {};
  plane.height = -plane.normal.dot(a);
  if (plane.height < 0) plane = {-plane.normal, -plane.height};
  if (-plane.normal.y() < kSteepest || !(plane.height > 0)) return {};
  return plane;
}

/// Points on the plane; none if more than a few lie under it, for then it is a table and not the floor.
std::vector<int> OnPlane(const std::vector<Eigen::Vector3d>& points, const Plane& plane) {
  std::vector<int> inliers;
  int under = 0;
  for (int i = 0; i < int(points.size()); ++i) {
    const double above = (plane.normal.dot(points[size_t(i)]) + plane.height) / plane.height;
    if (std::abs(above) < kThickness) inliers.push_back(i);
    under += above < -3 * kThickness;
  }
  constexpr int kPerPointUnder = 4;
  return int(inliers.size()) < kPerPointUnder * under ? std::vector<int>() : inliers;
}

Plane LeastSquares(const std::vector<Eigen::Vector3d>& points, const std::vector<int>& use, const Plane& otherwise) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int i : use) mean += points[size_t(i)] / double(use.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const int i : use) scatter += (points[size_t(i)] - mean) * (points[size_t(i)] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  Plane plane{eigen.eigenvectors().col(0), 0};
  if (plane.normal.y() > 0) plane.normal = -plane.normal;
  plane.height = -plane.normal.dot(mean);
  return -plane.normal.y() >= kSteepest && plane.height > 0 ? plane : otherwise;
}

}  // namespace

std::optional<FloorPlane> FindFloor(const std::vector<Eigen::Vector3d>& points, RandomStream& random) {
  if (int(points.size()) < kFewestInliers) return {};
  Plane best;
  std::vector<int> inliers;
  constexpr int kSamples = 200;
  for (int k = 0; k < kSamples; ++k) {
    const std::vector<int> s = internal::DrawSample(int(points.size()), 3, random);
    const auto plane = Through(points[size_t(s[0])], points[size_t(s[1])], points[size_t(s[2])]);
    if (!plane) continue;
    std::vector<int> on = OnPlane(points, *plane);
    if (on.size() > inliers.size()) {
      inliers = std::move(on);
      best = *plane;
    }
  }
  if (int(inliers.size()) < kFewestInliers) return {};
  return LeastSquares(points, inliers, best);
}

void FloorGuess::Update(const LandmarkMap& map, const Pose& X_WC, RandomStream& random) {
  const int newest = int(map.keyframes().size()) - 1;
  const Pose X_CW = X_WC.Inverse();
  std::vector<Eigen::Vector3d> points;
  for (const Landmark& landmark : map.landmarks()) {
    if (!landmark.Known() || landmark.observations.empty() || newest - landmark.last_keyframe > kLately) continue;
    const Eigen::Vector3d p_C = X_CW * map.Place(landmark);
    if (p_C.y() > 0) points.push_back(p_C);
  }
  const auto plane = FindFloor(points, random);
  if (!plane) return FindStanding(map, X_WC);
  const Eigen::Vector3d normal_W = X_WC.rotation * plane->normal;
  if (!height_) {
    height_ = plane->height;
    normal_W_ = normal_W;
  } else {
    constexpr double kFollow = 0.2;  // of each new normal: turns of the map drift slowly
    normal_W_ = ((1 - kFollow) * normal_W_ + kFollow * normal_W).normalized();
  }
  FindStanding(map, X_WC);
}

void FloorGuess::FindStanding(const LandmarkMap& map, const Pose& X_WC) {
  standing_.clear();
  if (!height_) return;
  // So far above, parts of the camera's height, that no floor point gets there when the map's scale has drifted.
  constexpr double kWellAbove = 0.25, kWellKnown = 0.1;
  constexpr size_t kSeenOften = 2;
  for (const Landmark& landmark : map.landmarks()) {
    if (landmark.observations.size() < kSeenOften || !(landmark.rho_sigma < kWellKnown * landmark.rho)) continue;
    const Eigen::Vector3d p_W = map.Place(landmark);
    if (normal_W_.dot(p_W - X_WC.translation) + *height_ > kWellAbove * *height_) standing_.push_back(p_W);
  }
}

bool FloorGuess::IsHidden(const Pose& X_WC, const Eigen::Vector3d& floor_point_W) const {
  const auto level = [&](const Eigen::Vector3d& p_W) -> Eigen::Vector3d {
    const Eigen::Vector3d v = p_W - X_WC.translation;
    return v - normal_W_.dot(v) * normal_W_;
  };
  const Eigen::Vector3d to_floor = level(floor_point_W);
  const double distance = to_floor.norm();
  constexpr double kAside = 0.1, kBefore = 0.9;  // tangent of the angle aside; part of the floor point's distance
  constexpr int kEnough = 3;                     // one may be wrong
  int before = 0;
  for (const Eigen::Vector3d& p_W : standing_) {
    const Eigen::Vector3d v = level(p_W);
    const double along = v.dot(to_floor) / distance;
    if (along <= 0 || along > kBefore * distance) continue;
    const double aside = std::sqrt(std::max(0.0, v.squaredNorm() - along * along));
    if (aside < kAside * along && ++before >= kEnough) return true;
  }
  return false;
}

std::optional<DepthGuess> FloorGuess::At(const Pose& X_WC, const Eigen::Vector2d& xy) const {
  if (!height_) return {};
  const Eigen::Vector3d ray = X_WC.rotation * xy.homogeneous();
  const double rho = -normal_W_.dot(ray) / *height_, tilt = kTiltSpread_rad * ray.norm() / *height_;
  const double sigma = std::hypot(kHeightSpread * rho, tilt);
  constexpr double kUseful =
      0.25;  // a guess vaguer than this, part of itself, is none: the feature is near the horizon
  if (!(sigma < kUseful * rho) || IsHidden(X_WC, X_WC.translation + ray / rho)) return {};
  return DepthGuess{rho, sigma};
}

}  // namespace gaitcam
