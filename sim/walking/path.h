/// The reference path of a robot: a chain of straight lines, arcs and turns on the spot on the floor.
///
/// A path is geometry only; speed and feedback belong to the walker that follows it.

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// Shape of a path.
enum class PathKind { kStraight, kCircle, kPolyline, kThereAndBack, kSquare, kStand };
constexpr auto WordsOf(PathKind) {
  return std::array{EnumWord{PathKind::kStraight, "straight"}, EnumWord{PathKind::kCircle, "circle"},
                    EnumWord{PathKind::kPolyline, "polyline"}, EnumWord{PathKind::kThereAndBack, "there_and_back"},
                    EnumWord{PathKind::kSquare, "square"},     EnumWord{PathKind::kStand, "stand"}};
}

/// Sense of a circle, of a square and of turning back.
enum class PathDirection { kLeft, kRight };
constexpr auto WordsOf(PathDirection) {
  return std::array{EnumWord{PathDirection::kLeft, "left"}, EnumWord{PathDirection::kRight, "right"}};
}

/// What corrects the robot's course: its true pose, its own odometry, or nothing (open loop).
enum class PathFeedback { kTruth, kOdometry, kNone };
constexpr auto WordsOf(PathFeedback) {
  return std::array{EnumWord{PathFeedback::kTruth, "truth"}, EnumWord{PathFeedback::kOdometry, "odometry"},
                    EnumWord{PathFeedback::kNone, "none"}};
}

struct PathOptions {
  using DescribedTag = void;

  PathKind kind = PathKind::kStraight;
  double length_m = 5.0;
  double diameter_m = 4.0;
  double side_m = 2.0;
  std::vector<Eigen::Vector2d> points;
  std::optional<double> corner_radius_m;
  PathDirection direction = PathDirection::kLeft;
  int laps = 1;
  double duration_s = 10.0;
  double pan_amplitude_rad = 0.5;
  double pan_period_s = 4.0;
  double head_tilt_rad = 0.1;
  PathFeedback feedback =
      PathFeedback::kTruth;  ///< What steers: "truth", the robot's own "odometry", or "none" (open loop).
  double settle_s = 1.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, PathOptions& o) {
  visit("kind", o.kind, EnumWords<PathKind>(), "shape");
  visit("length_m", o.length_m, Between(0.05, 1000.0), "of a straight, or of each leg of there_and_back");
  visit("diameter_m", o.diameter_m, Between(0.2, 200.0), "of a circle");
  visit("side_m", o.side_m, Between(0.1, 200.0), "of a square");
  visit("points", o.points, Nested(),
        "corners of a polyline as [x, y], m in the start frame; the start (0, 0) is implied");
  visit("corner_radius_m", o.corner_radius_m, Nested(),
        "a polyline's corners are walked as arcs of this radius; absent: it turns on the spot in them");
  visit("direction", o.direction, EnumWords<PathDirection>(),
        "sense of circle, square and of the turn of there_and_back");
  visit("laps", o.laps, Between(1, 1000), "rounds of a circle or square");
  visit("duration_s", o.duration_s, Between(0.1, 3600.0), "of standing");
  visit("pan_amplitude_rad", o.pan_amplitude_rad, Between(0.0, 1.5), "amplitude of the neck's sine while standing");
  visit("pan_period_s", o.pan_period_s, Between(0.2, 60.0), "period of the neck's sine while standing");
  visit("head_tilt_rad", o.head_tilt_rad, Between(-1.0, 1.0), "constant tilt of the head; positive looks down");
  visit("feedback", o.feedback, EnumWords<PathFeedback>(),
        "what corrects the robot's course: its true pose, its own odometry, or none (open loop)");
  visit("settle_s", o.settle_s, Between(0.2, 60.0), "standing still before the first and after the last step");
}

/// A segment of constant curvature; with length 0, a turn on the spot.
struct PathSegment {
  PlanarPose start;
  double length_m = 0;
  double turn_rad = 0;  ///< Change of heading over the segment, positive to the left.

  bool IsTurnOnTheSpot() const { return length_m == 0; }
  double Curvature() const { return IsTurnOnTheSpot() ? 0 : turn_rad / length_m; }  ///< 1/m
  PlanarPose At(double s) const;  ///< `s` in m from the segment's start, also beyond its ends.
  PlanarPose end() const;

  /// How far along the segment the point nearest to `p` lies (m; may be negative or beyond the length), and how far `p`
  /// lies to the left of it (m). @pre not a turn on the spot. For an arc, `along` is the branch nearest to `near_s`.
  struct Location {
    double along = 0, left = 0;
  };
  Location Locate(const Eigen::Vector2d& p, double near_s) const;
};

class Path {
 public:
  /// @param start where the robot stands at first, x forward; height, roll and pitch are ignored.
  /// @throws BadOption for a polyline without points, with two equal neighbours, or with a leg too short for the arcs
  /// at its ends, and for fields out of range.
  Path(const PathOptions& options, const Pose& start);

  /// A turn on the spot towards `goal`, a straight line, and a turn on the spot into its heading; turns by at most pi,
  /// and none before a line shorter than a centimetre.
  static Path ToGoal(const PlanarPose& start, const PlanarPose& goal);

  const std::vector<PathSegment>& segments() const { return segments_; }  ///< Empty for standing.
  PlanarPose start() const { return start_; }
  PlanarPose goal() const { return segments_.empty() ? start_ : segments_.back().end(); }

  /// Arc length on the floor, m; turns on the spot add nothing.
  double Length() const;
  /// Sum of the absolute turns, rad.
  double TotalTurn() const;
  /// Reference pose after `s` m, in [0, Length()]; at a corner, the pose before the turn.
  PlanarPose PoseAt(double s) const;

  /// At constant speeds: m/s along the path, rad/s in turns on the spot.
  double Duration(double speed, double turn_rate) const;
  PlanarPose PoseAtTime(double t, double speed, double turn_rate) const;

  /// Distance from `p` to the nearest point of the path, m.
  double DistanceTo(const Eigen::Vector2d& p) const;

 private:
  explicit Path(const PlanarPose& start) : start_(start) {}
  void AddLine(double length_m);
  void AddArc(double radius_m, double turn_rad);
  void AddTurn(double turn_rad);
  void AddPolyline(const PathOptions& options);
  void Add(double length_m, double turn_rad);

  PlanarPose start_;
  std::vector<PathSegment> segments_;
};

}  // namespace gaitcam
