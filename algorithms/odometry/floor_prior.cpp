#include "algorithms/odometry/floor_prior.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "algorithms/geometry/ransac.h"

namespace gaitcam {
namespace {

constexpr int kMinInliers = 40;
constexpr double kMinUpCosine = 0.82;    // between the normal and the camera's up: 35 degrees
constexpr double kThickness = 0.06;      // largest distance of an inlier, relative to the camera's height
constexpr double kHeightSigma = 0.06;    // relative standard deviation of a walking camera's height
constexpr double kTiltSigma_rad = 0.02;  // standard deviation of the normal's direction
constexpr int kMaxAge = 5;               // keyframes since a landmark was seen

using Plane = FloorPlane;

std::optional<Plane> Through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Plane plane;
  plane.normal = (b - a).cross(c - a).normalized();
  if (!plane.normal.allFinite()) return {};
  plane.height = -plane.normal.dot(a);
  if (plane.height < 0) plane = {-plane.normal, -plane.height};
  if (-plane.normal.y() < kMinUpCosine || !(plane.height > 0)) return {};
  return plane;
}

/// Inliers; none if more than a few points lie below the plane, which then is a table's and not the floor.
std::vector<int> OnPlane(const std::vector<Eigen::Vector3d>& points, const Plane& plane) {
  std::vector<int> inliers;
  int below = 0;
  for (int i = 0; i < int(points.size()); ++i) {
    const double above = (plane.normal.dot(points[size_t(i)]) + plane.height) / plane.height;
    if (std::abs(above) < kThickness) inliers.push_back(i);
    below += above < -3 * kThickness;
  }
  constexpr int kPerPointBelow = 4;
  return int(inliers.size()) < kPerPointBelow * below ? std::vector<int>() : inliers;
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
  return -plane.normal.y() >= kMinUpCosine && plane.height > 0 ? plane : otherwise;
}

}  // namespace

std::optional<FloorPlane> FindFloor(const std::vector<Eigen::Vector3d>& points, RandomStream& random) {
  if (int(points.size()) < kMinInliers) return {};
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
  if (int(inliers.size()) < kMinInliers) return {};
  return LeastSquares(points, inliers, best);
}

void FloorPrior::Update(const KeyframeMap& map, const Pose& X_WC, RandomStream& random) {
  const int newest = int(map.keyframes().size()) - 1;
  const Pose X_CW = X_WC.Inverse();
  std::vector<Eigen::Vector3d> points;
  for (const Landmark& landmark : map.landmarks()) {
    if (!landmark.HasDepth() || landmark.observations.empty() || newest - landmark.last_keyframe > kMaxAge) continue;
    const Eigen::Vector3d p_C = X_CW * map.Position(landmark);
    if (p_C.y() > 0) points.push_back(p_C);
  }
  const auto plane = FindFloor(points, random);
  if (!plane) return FindObstacles(map, X_WC, height_.value_or(0), {});
  const Eigen::Vector3d normal_W = X_WC.rotation * plane->normal;
  if (!height_) {
    height_ = plane->height;
    normal_W_ = normal_W;
  } else {
    constexpr double kGain = 0.2;  // of a low-pass filter: the map's orientation drifts slowly
    normal_W_ = ((1 - kGain) * normal_W_ + kGain * normal_W).normalized();
  }
  FindObstacles(map, X_WC, *height_, {});
}

void FloorPrior::Update(const KeyframeMap& map, const Pose& X_WC, const Carried& carried,
                        const std::optional<CarriedHeight>& measured) {
  constexpr int kMeasurements = 5;
  normal_W_ = measured ? measured->normal_W : carried.up_W;
  if (measured && measurements_ < kMeasurements) {
    const double before = height_.value_or(0);
    ++measurements_;
    height_ = before + (measured->height - before) / measurements_;
  }
  if (measured) return FindObstacles(map, X_WC, measured->height, measured->seen_on_floor_W);
  FindObstacles(map, X_WC, height_.value_or(0), {});
}

/// In the camera's place, over the floor.
FloorPrior::Standing FloorPrior::StandingAt(const Pose& X_WC, const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d v = p_W - X_WC.translation;
  const double up = normal_W_.dot(v);
  return {v - up * normal_W_, up + height_now_};
}

/// Whether something that reaches from the floor up to `obstacle` hides a point of the floor.
bool FloorPrior::Hides(const Standing& obstacle, const Standing& floor_point) const {
  constexpr double kMaxTangent = 0.1;   // of the horizontal angle between the two
  constexpr double kMaxDistance = 0.9;  // of the obstacle, relative to the floor point's
  const double distance = floor_point.level.norm();
  const double along = obstacle.level.dot(floor_point.level) / distance;
  if (along <= 0 || along > kMaxDistance * distance) return false;
  const double aside2 = obstacle.level.squaredNorm() - along * along;
  const double ray_height = height_now_ * (1 - along / distance);  // where it passes the obstacle
  return aside2 < std::pow(kMaxTangent * along, 2) && ray_height < obstacle.height;
}

/// Landmarks well above the floor, but for those that landmarks on the floor are seen through: matched wrongly.
/// @param height of the camera over the floor of the map, whose unit may have drifted; 0: unknown
void FloorPrior::FindObstacles(const KeyframeMap& map, const Pose& X_WC, double height,
                               const std::vector<Eigen::Vector3d>& seen_on_floor_W) {
  obstacles_.clear();
  height_now_ = height;
  if (!(height > 0)) return;
  std::vector<Standing> seen_on_floor;
  for (const Eigen::Vector3d& p_W : seen_on_floor_W) seen_on_floor.push_back(StandingAt(X_WC, p_W));
  // Relative to the camera's height; higher than drift of scale lifts a point of the floor.
  constexpr double kMinHeight = 0.25, kMaxDepthSigma = 0.1;
  constexpr size_t kMinObservations = 2;
  constexpr int kMinSeenThrough = 2;
  for (const Landmark& landmark : map.landmarks()) {
    if (landmark.observations.size() < kMinObservations || !(landmark.rho_sigma < kMaxDepthSigma * landmark.rho))
      continue;
    const Eigen::Vector3d p_W = map.Position(landmark);
    const Standing obstacle = StandingAt(X_WC, p_W);
    if (!(obstacle.height > kMinHeight * height)) continue;
    const auto hidden = std::count_if(seen_on_floor.begin(), seen_on_floor.end(),
                                      [&](const Standing& point) { return Hides(obstacle, point); });
    if (hidden < kMinSeenThrough) obstacles_.push_back(p_W);
  }
}

bool FloorPrior::IsOccluded(const Pose& X_WC, const Eigen::Vector3d& floor_point_W) const {
  const Standing floor_point = StandingAt(X_WC, floor_point_W);
  constexpr int kMinObstacles = 3;  // one may be an outlier
  int count = 0;
  for (const Eigen::Vector3d& p_W : obstacles_) {
    if (Hides(StandingAt(X_WC, p_W), floor_point) && ++count >= kMinObstacles) return true;
  }
  return false;
}

std::optional<DepthPrior> FloorPrior::DepthAt(const Pose& X_WC, const Eigen::Vector2d& xy) const {
  if (!height_) return {};
  const Eigen::Vector3d ray = X_WC.rotation * xy.homogeneous();
  const double rho = -normal_W_.dot(ray) / *height_, tilt = kTiltSigma_rad * ray.norm() / *height_;
  const double sigma = std::hypot(kHeightSigma * rho, tilt);
  constexpr double kMaxSigma = 0.25;  // relative; beyond it the feature is near the horizon
  if (!(sigma < kMaxSigma * rho) || IsOccluded(X_WC, X_WC.translation + height_now_ / *height_ / rho * ray)) return {};
  return DepthPrior{rho, sigma};
}

}  // namespace gaitcam
