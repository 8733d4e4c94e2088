#include "algorithms/slam/taught_ways.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr double kMostTrusted = 0.5;
constexpr double kAnotherPass_m = 3;  // a shortcut within one pass cuts the corner that was taught
constexpr double kTogether_m = 0.6, kSameWay_rad = 30 * kRadPerDeg;  // of two passes
constexpr double kChange_m = 0.2;                                    // what a change of pass costs, as way

double Apart_rad(double a, double b) { return std::abs(WrapAngle(a - b)); }

}  // namespace

TaughtWays::TaughtWays(const RouteMap& map) : X_BC_(map.X_BC), steps_(map.graph.nodes.size()) {
  std::vector<double> along_m;
  for (const GraphNode& node : map.graph.nodes) {
    X_FB_.push_back(InFloor(node.X_WC));
    const int v = size() - 1;
    along_m.push_back(v == 0 ? 0 : along_m.back() + (At(v).position - At(v - 1).position).norm());
    const bool begins = std::find(map.sessions.begin(), map.sessions.end(), v) != map.sessions.end();
    if (v > 0 && !begins) AddStep(v - 1, v, 0);
  }
  for (const GraphLink& link : map.graph.links) {
    const bool another_pass = SessionOf(map, link.from) != SessionOf(map, link.to) ||
                              std::abs(along_m[size_t(link.from)] - along_m[size_t(link.to)]) > kAnotherPass_m;
    const bool together = (At(link.from).position - At(link.to).position).norm() < kTogether_m &&
                          Apart_rad(At(link.from).heading, At(link.to).heading) < kSameWay_rad;
    if (!link.loop || link.trust < kMostTrusted || !another_pass || !together) continue;
    AddStep(link.from, link.to, kChange_m);
    AddStep(link.to, link.from, kChange_m);
  }
}

void TaughtWays::AddStep(int from, int to, double cost_m) {
  steps_[size_t(from)].push_back({to, cost_m + (At(from).position - At(to).position).norm()});
}

PlanarPose TaughtWays::InFloor(const Pose& X_WC) const { return PlanarPose(CameraInFloor(X_WC) * X_BC_.Inverse()); }

int TaughtWays::Nearest(const Eigen::Vector2d& point_m, double within_m) const {
  int best = -1;
  for (int v = 0; v < size(); ++v) {
    const double away_m = (At(v).position - point_m).norm();
    if (away_m <= within_m) best = v, within_m = away_m;
  }
  return best;
}

int TaughtWays::Nearest(const PlanarPose& X_FB, double within_m) const {
  int best = -1;
  for (int v = 0; v < size(); ++v) {
    const double away_m = (At(v).position - X_FB.position).norm();
    if (away_m > within_m || Apart_rad(At(v).heading, X_FB.heading) > 2 * kSameWay_rad) continue;
    best = v, within_m = away_m;
  }
  return best;
}

/// Dijkstra's.
std::vector<int> TaughtWays::Shortest(int from, int to, const std::set<int>& closed) const {
  using Reached = std::pair<double, int>;
  std::vector<double> cost_m(X_FB_.size(), std::numeric_limits<double>::infinity());
  std::vector<int> before(X_FB_.size(), -1);
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
  cost_m[size_t(from)] = 0;
  open.emplace(0, from);
  while (!open.empty()) {
    const auto [cost, view] = open.top();
    open.pop();
    if (view == to) break;
    if (cost > cost_m[size_t(view)]) continue;
    for (const Step& step : steps_[size_t(view)]) {
      const double reached = cost + step.length_m;
      if (reached >= cost_m[size_t(step.to)] || closed.contains(step.to)) continue;
      cost_m[size_t(step.to)] = reached;
      before[size_t(step.to)] = view;
      open.emplace(reached, step.to);
    }
  }
  if (!std::isfinite(cost_m[size_t(to)])) return {};
  std::vector<int> way{to};
  while (way.back() != from) way.push_back(before[size_t(way.back())]);
  std::reverse(way.begin(), way.end());
  return way;
}

// ---------------------------------------------------------------------------------------------------------------------

namespace {

/// Views of a parabola through five that are equally far apart, at the middle one (Savitzky and Golay 1964).
constexpr std::array<double, 3> kParabola = {17.0 / 35, 12.0 / 35, -3.0 / 35};

PlanarPose Smoothed(const std::vector<PlanarPose>& poses, size_t i) {
  constexpr double kFar_m = 1;
  if (i < 2 || i + 2 >= poses.size()) return poses[i];
  PlanarPose smooth({0, 0}, 0);
  for (size_t k = i - 2; k <= i + 2; ++k) {
    if ((poses[k].position - poses[i].position).norm() > kFar_m) return poses[i];
    const double weight = kParabola[k < i ? i - k : k - i];
    smooth.position += weight * poses[k].position;
    smooth.heading += weight * poses[k].heading;
  }
  return smooth;
}

}  // namespace

Route::Route(const std::vector<PlanarPose>& poses) {
  std::vector<PlanarPose> taught;
  for (const PlanarPose& pose : poses) {
    const double last = taught.empty() ? pose.heading : taught.back().heading;
    taught.emplace_back(pose.position, last + WrapAngle(pose.heading - last));
  }
  for (size_t i = 0; i < taught.size(); ++i) {
    poses_.push_back(Smoothed(taught, i));
    const double step_m = i == 0 ? 0 : (poses_[i].position - poses_[i - 1].position).norm();
    along_m_.push_back(i == 0 ? 0 : along_m_.back() + step_m);
  }
}

/// The piece from this pose to the next one. @pre two poses or more.
size_t Route::PieceAt(double along_m) const {
  const auto after = std::upper_bound(along_m_.begin(), along_m_.end(), along_m);
  const size_t piece = after == along_m_.begin() ? 0 : size_t(after - along_m_.begin()) - 1;
  return std::min(piece, poses_.size() - 2);
}

PlanarPose Route::At(double along_m) const {
  GAITCAM_ASSERT(!poses_.empty());
  if (poses_.size() == 1) return poses_[0];
  const size_t i = PieceAt(along_m);
  const double length = along_m_[i + 1] - along_m_[i];
  const double part = length > 0 ? std::clamp((along_m - along_m_[i]) / length, 0.0, 1.0) : 0;
  return {poses_[i].position + part * (poses_[i + 1].position - poses_[i].position),
          poses_[i].heading + part * (poses_[i + 1].heading - poses_[i].heading)};
}

double Route::DirectionAt(double along_m) const {
  constexpr double kReach_m = 0.1;
  const Eigen::Vector2d way = At(along_m + kReach_m).position - At(along_m - kReach_m).position;
  return way.norm() > 0 ? std::atan2(way.y(), way.x()) : At(along_m).heading;
}

double Route::Nearest(const Eigen::Vector2d& point_m, double from_m, double to_m) const {
  if (poses_.size() < 2) return 0;
  double best = std::clamp(from_m, 0.0, length_m()), least = std::numeric_limits<double>::infinity();
  for (size_t i = PieceAt(from_m); i + 1 < poses_.size() && along_m_[i] <= to_m; ++i) {
    const Eigen::Vector2d a = poses_[i].position, way = poses_[i + 1].position - a;
    const double length2 = way.squaredNorm();
    const double part = length2 > 0 ? std::clamp((point_m - a).dot(way) / length2, 0.0, 1.0) : 0;
    const double along = std::clamp(along_m_[i] + part * std::sqrt(length2), from_m, to_m);
    const double away = (At(along).position - point_m).norm();
    if (away < least) least = away, best = along;
  }
  return best;
}

}  // namespace gaitcam
