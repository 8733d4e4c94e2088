#include "sim/walking/path.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {}  // namespace

PlanarPose PathSegment::At(double s) const {
  // Constant curvature k: chord 2/k sin(k s / 2) in the direction of half the turn.
  const double half_turn = 0.5 * Curvature() * s;
  const double shrink = std::abs(half_turn) < 1e-9 ? 1.0 : std::sin(half_turn) / half_turn;
  return start * PlanarPose(Rotate({s * shrink, 0}, half_turn), 2 * half_turn);
}

PlanarPose PathSegment::end() const {
  if (IsTurnOnTheSpot()) return {start.position, start.heading + turn_rad};
  return At(length_m);
}

PathSegment::Location PathSegment::Locate(const Eigen::Vector2d& p, double near_s) const {
  GAITCAM_ASSERT(!IsTurnOnTheSpot());
  const Eigen::Vector2d local = start.Inverse() * p;
  const double curvature = Curvature();
  if (std::abs(curvature) < 1e-9) return {local.x(), local.y()};
  const double radius = 1 / curvature;  // signed: the centre lies at (0, radius)
  const Eigen::Vector2d from_center = local - Eigen::Vector2d(0, radius);
  const double side = radius > 0 ? 1 : -1;
  const double angle = std::atan2(side * from_center.x(), -side * from_center.y());
  const double near_angle = near_s * curvature;
  const double unwrapped = near_angle + WrapAngle(angle - near_angle);
  return {unwrapped * radius, side * (std::abs(radius) - from_center.norm())};
}

Path::Path(const PathOptions& options, const Pose& start) : start_(start) {
  CheckFields(options, "path.");
  const double sense = options.direction == PathDirection::kLeft ? 1 : -1;
  if (options.kind == PathKind::kStraight) {
    AddLine(options.length_m);
  } else if (options.kind == PathKind::kCircle) {
    for (int lap = 0; lap < options.laps; ++lap) AddArc(options.diameter_m / 2, sense * 2 * kPi);
  } else if (options.kind == PathKind::kThereAndBack) {
    AddLine(options.length_m);
    AddTurn(sense * kPi);
    AddLine(options.length_m);
  } else if (options.kind == PathKind::kSquare) {
    for (int side = 0; side < 4 * options.laps; ++side) {
      AddLine(options.side_m);
      AddTurn(sense * kPi / 2);
    }
  } else if (options.kind == PathKind::kPolyline) {
    AddPolyline(options);
  }
  constexpr double kLongest_m = 10000;
  if (Length() > kLongest_m) {
    throw BadOption("path: it is " + internal::NumberText(Length()) + " m long; expected at most 10000 m");
  }
}

Path Path::ToGoal(const PlanarPose& start, const PlanarPose& goal) {
  constexpr double kShort_m = 0.01, kSmall_rad = 1e-6;
  Path path(start);
  const Eigen::Vector2d way = goal.position - start.position;
  const auto turn_to = [&](double heading) {
    const double turn = WrapAngle(heading - path.goal().heading);
    if (std::abs(turn) > kSmall_rad) path.AddTurn(turn);
  };
  if (way.norm() > kShort_m) {
    turn_to(std::atan2(way.y(), way.x()));
    path.AddLine(way.norm());
  }
  turn_to(goal.heading);
  return path;
}

void Path::Add(double length_m, double turn_rad) { segments_.push_back({goal(), length_m, turn_rad}); }
void Path::AddLine(double length_m) { Add(length_m, 0); }
void Path::AddArc(double radius_m, double turn_rad) { Add(radius_m * std::abs(turn_rad), turn_rad); }
void Path::AddTurn(double turn_rad) { Add(0, turn_rad); }

void Path::AddPolyline(const PathOptions& options) {
  const std::vector<Eigen::Vector2d>& points = options.points;
  if (points.empty()) throw BadOption("path.points: a polyline needs at least one point, as in [[1, 0], [1, 1]]");
  const double radius_m = options.corner_radius_m.value_or(0);
  if (options.corner_radius_m && !(radius_m > 0 && std::isfinite(radius_m))) {
    throw BadOption("path.corner_radius_m: " + internal::NumberText(radius_m) +
                    " is not permitted; expected a length above 0, or no such key");
  }
  const bool rounded = radius_m > 0;
  const auto heading_of = [](const Eigen::Vector2d& way) { return std::atan2(way.y(), way.x()); };
  double cut_m = 0;  // what the arc at a leg's beginning has taken of it
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d corner = start_ * points[i];
    const Eigen::Vector2d way = corner - (rounded && i > 0 ? start_ * points[i - 1] : goal().position);
    if (way.norm() < 1e-3) {
      throw BadOption("path.points: point " + std::to_string(i + 1) +
                      " lies on the one before it (the path starts at [0, 0]); neighbours must differ");
    }
    const double turn = WrapAngle(heading_of(way) - goal().heading);
    if (std::abs(turn) > 1e-6 && !(rounded && i > 0)) AddTurn(turn);
    const bool bends = rounded && i + 1 < points.size();
    const double bend = bends ? WrapAngle(heading_of(start_ * points[i + 1] - corner) - heading_of(way)) : 0;
    const double reach_m = radius_m * std::tan(std::abs(bend) / 2), left_m = way.norm() - cut_m;
    if (reach_m > left_m) {
      throw BadOption("path.corner_radius_m: " + internal::NumberText(radius_m) +
                      " is too much for the corner at point " + std::to_string(i + 1) +
                      " of path.points; expected less");
    }
    if (left_m - reach_m > 1e-9) AddLine(left_m - reach_m);
    if (reach_m > 1e-9) AddArc(radius_m, bend);
    cut_m = reach_m;
  }
}

double Path::Length() const {
  double sum = 0;
  for (const PathSegment& segment : segments_) sum += segment.length_m;
  return sum;
}

double Path::TotalTurn() const {
  double sum = 0;
  for (const PathSegment& segment : segments_) sum += std::abs(segment.turn_rad);
  return sum;
}

PlanarPose Path::PoseAt(double s) const {
  for (const PathSegment& segment : segments_) {
    if (s <= segment.length_m) return segment.At(std::max(0.0, s));
    s -= segment.length_m;
  }
  return goal();
}

double Path::Duration(double speed, double turn_rate) const {
  double sum = 0;
  for (const PathSegment& segment : segments_) {
    sum += segment.IsTurnOnTheSpot() ? std::abs(segment.turn_rad) / turn_rate : segment.length_m / speed;
  }
  return sum;
}

PlanarPose Path::PoseAtTime(double t, double speed, double turn_rate) const {
  t = std::max(0.0, t);
  for (const PathSegment& segment : segments_) {
    const bool turn = segment.IsTurnOnTheSpot();
    const double duration = turn ? std::abs(segment.turn_rad) / turn_rate : segment.length_m / speed;
    if (t <= duration) {
      if (!turn) return segment.At(t * speed);
      return {segment.start.position, segment.start.heading + std::copysign(t * turn_rate, segment.turn_rad)};
    }
    t -= duration;
  }
  return goal();
}

double Path::DistanceTo(const Eigen::Vector2d& p) const {
  double nearest = (p - start_.position).norm();
  for (const PathSegment& segment : segments_) {
    if (segment.IsTurnOnTheSpot()) continue;
    const double along = segment.Locate(p, segment.length_m / 2).along;
    nearest = std::min(nearest, (p - segment.At(std::clamp(along, 0.0, segment.length_m)).position).norm());
  }
  return nearest;
}

}  // namespace gaitcam
