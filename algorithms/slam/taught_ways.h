/// The ways that a map knows, and the shortest one to a goal.
///
/// Source: Hua, section 6.1.2, which plans by Dijkstra's algorithm on the topology of the map.
///
/// A way goes from view to view in the order in which they were taken: there the robot sees what the map shows. From
/// one pass to another of the same place it changes over where a loop closure joins views that lie together and face
/// the same way.

#pragma once

#include <Eigen/Core>
#include <set>
#include <vector>

#include "algorithms/core/planar_pose.h"
#include "algorithms/core/route_map.h"

namespace gaitcam {

class TaughtWays {
 public:
  explicit TaughtWays(const RouteMap& map);

  /// Where the body stood at a view, in the taught floor frame F (taught_drive.h).
  const PlanarPose& At(int view) const { return X_FB_[size_t(view)]; }
  int size() const { return int(X_FB_.size()); }
  /// Of a camera's pose in the map's world, the same in F, and the body's.
  Pose CameraInFloor(const Pose& X_WC) const { return X_BC_ * X_WC; }
  PlanarPose InFloor(const Pose& X_WC) const;

  /// The view where the body stood nearest to a point; -1 if all are farther away than `within_m`.
  int Nearest(const Eigen::Vector2d& point_m, double within_m) const;
  /// ... to a pose, facing the same way within 60 degrees.
  int Nearest(const PlanarPose& X_FB, double within_m) const;

  /// Views from one to another, both included; empty if there is no way. @param closed views that it must not enter.
  std::vector<int> Shortest(int from, int to, const std::set<int>& closed = {}) const;

 private:
  struct Step {
    int to;
    double length_m;
  };
  void AddStep(int from, int to, double cost_m);

  Pose X_BC_;
  std::vector<PlanarPose> X_FB_;
  std::vector<std::vector<Step>> steps_;
};

/// A polyline over the floor, driven with the heading that it was taught with.
class Route {
 public:
  Route() = default;
  /// Corners that a loop closure's errors put in are rounded off: each pose is that of the parabola through the two
  /// views before and the two after it, by least squares, which cuts no corner that was driven round.
  explicit Route(const std::vector<PlanarPose>& poses);

  double length_m() const { return along_m_.empty() ? 0 : along_m_.back(); }
  bool empty() const { return poses_.empty(); }
  /// Headings are interpolated. @param along_m clamped to the route.
  PlanarPose At(double along_m) const;
  /// Direction of travel, rad.
  double DirectionAt(double along_m) const;
  /// Where along the route, between two limits, it comes nearest to a point.
  double Nearest(const Eigen::Vector2d& point_m, double from_m, double to_m) const;

 private:
  size_t PieceAt(double along_m) const;

  std::vector<PlanarPose> poses_;  ///< Headings without jumps by whole turns.
  std::vector<double> along_m_;    ///< Of each pose.
};

}  // namespace gaitcam
