#include "algorithms/slam/way_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr int kEvery_px = 8;
constexpr double kLow_m = 0.2, kHigh_m = 2.0;  // over the floor: what a robot and its mast could touch
constexpr double kStep_m = 0.1;                // along the way

constexpr double kMoved_m = 0.2;     // nearer than what was seen there before
constexpr double kNearest_m = 0.6;   // before which a depth camera measures nothing: no reason to be new
constexpr double kStillThere_s = 1;  // so long who moved is taken to be as near
constexpr double kRemembered_m = 2;  // farther away, there is time to look again

/// The least that was measured within so many pixels; 0 where nothing was.
cv::Mat NearestAround(const cv::Mat& depth, int reach_px) {
  constexpr float kNothing_m = 1e6F;
  cv::Mat near_m = depth.clone();
  near_m.setTo(kNothing_m, ~(depth > 0));
  cv::erode(near_m, near_m, cv::Mat::ones(2 * reach_px + 1, 2 * reach_px + 1, CV_8U));
  near_m.setTo(0, near_m >= kNothing_m);
  return near_m;
}

}  // namespace

WayGuard::WayGuard(const Calibration& calibration, const WayGuardOptions& options)
    : calibration_(calibration), options_(options) {
  CheckFields(options, "guard.");
}

std::vector<WayGuard::Point> WayGuard::PointsOf(int64_t stamp_ns, const Pose& X_FC, const cv::Mat& depth) const {
  std::vector<Point> points;
  for (int row = kEvery_px / 2; row < depth.rows; row += kEvery_px) {
    for (int column = kEvery_px / 2; column < depth.cols; column += kEvery_px) {
      const double z = double(depth.at<float>(row, column));
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3d p_F = X_FC * Eigen::Vector3d(z * calibration_.camera.Unproject({column, row}));
      if (p_F.z() > kLow_m && p_F.z() < kHigh_m) points.push_back({p_F, stamp_ns});
    }
  }
  return points;
}

std::optional<double> WayGuard::DepthTowards(const Eigen::Vector3d& p_F, const View& view) const {
  const std::optional<Eigen::Vector2d> at = calibration_.camera.Project(view.X_CF * p_F);
  if (!at) return std::nullopt;
  const cv::Point pixel(int(std::lround(at->x())), int(std::lround(at->y())));
  if (!cv::Rect({0, 0}, view.depth.size()).contains(pixel)) return std::nullopt;
  const double z = double(view.depth.at<float>(pixel));
  return std::isfinite(z) ? std::max(z, 0.0) : 0;
}

void WayGuard::Forget() {
  points_.clear();
  before_.clear();
  moving_.clear();
}

void WayGuard::See(int64_t stamp_ns, const Pose& X_FC, const cv::Mat& depth) {
  constexpr size_t kBefore = 2;
  const View view{depth, X_FC.Inverse()};
  const Eigen::Vector2d body_F = (X_FC * calibration_.odometry.X_BC.Inverse()).translation.head<2>();
  const auto age_s = [&](int64_t then_ns) { return 1e-9 * double(stamp_ns - then_ns); };
  std::erase_if(points_, [&](const Point& point) {
    return age_s(point.stamp_ns) > options_.memory_s || (point.p_F.head<2>() - body_F).norm() > kRemembered_m ||
           DepthTowards(point.p_F, view) > 0.0;
  });
  const std::vector<Point> now = PointsOf(stamp_ns, X_FC, depth);
  std::erase_if(moving_, [&](const auto& seen) { return age_s(seen.first) > kStillThere_s; });
  if (!before_.empty()) moving_.emplace_back(stamp_ns, NearestMoving(now, body_F));
  points_.insert(points_.end(), now.begin(), now.end());
  const double reach_px = calibration_.camera.fx * std::tan(kRadPerDeg * options_.pose_error_deg);
  before_.push_back({NearestAround(depth, int(std::lround(reach_px))), view.X_CF});
  if (before_.size() > kBefore) before_.erase(before_.begin());
}

/// One of the last frames saw past it.
bool WayGuard::HasMoved(const Eigen::Vector3d& p_F) const {
  return std::any_of(before_.begin(), before_.end(), [&](const View& view) {
    const std::optional<double> seen_m = DepthTowards(p_F, view);
    const double here_m = (view.X_CF * p_F).z();
    return seen_m && here_m > kNearest_m && (*seen_m == 0 || *seen_m > here_m + kMoved_m);
  });
}

/// From the body's surface to where fewer than min_points that have moved are nearer.
double WayGuard::NearestMoving(const std::vector<Point>& points, const Eigen::Vector2d& body_F) const {
  std::vector<double> away_m;
  for (const Point& point : points) {
    if (HasMoved(point.p_F)) away_m.push_back((point.p_F.head<2>() - body_F).norm() - options_.body_radius_m);
  }
  const size_t enough = size_t(options_.min_points);
  if (away_m.size() < enough) return std::numeric_limits<double>::infinity();
  std::nth_element(away_m.begin(), away_m.begin() + long(enough) - 1, away_m.end());
  return away_m[enough - 1];
}

/// While the robot brakes from v by b after tau, it goes v^2 / 2b, and somebody w (tau + v / b) towards it.
double WayGuard::SpeedAmongWalkers(const Stop& stop) const {
  double away_m = std::numeric_limits<double>::infinity();
  for (const auto& [stamp_ns, seen_m] : moving_) away_m = std::min(away_m, seen_m);
  const double w = options_.walker_mps, room_m = away_m - options_.clearance_m - stop.going_m - w * stop.reaction_s;
  return room_m <= 0 ? 0 : std::sqrt(w * w + 2 * stop.brake_mps2 * room_m) - w;
}

double WayGuard::FreeWay(const std::function<Eigen::Vector2d(double)>& ahead) const {
  const double apart_m = options_.body_radius_m + options_.clearance_m;
  for (double along = 0; along <= options_.look_m; along += kStep_m) {
    const Eigen::Vector2d middle = ahead(along);
    const auto hits = std::count_if(points_.begin(), points_.end(), [&](const Point& point) {
      return (point.p_F.head<2>() - middle).squaredNorm() < apart_m * apart_m;
    });
    if (hits >= options_.min_points) return std::max(0.0, along - kStep_m);
  }
  return options_.look_m;
}

}  // namespace gaitcam
