/// Navigation on a learned map: localisation in it, the shortest taught way to a goal, and a body that follows it.
///
/// Source: Hua, section 6.1.2. There the robot stands at model i, moves by Pos_Move = (L_(i + omega) - L_i) + RelPose
/// (Eq. 6.5), its pose against model i + omega, and does so again until the goal. Here the same difference is taken
/// anew at every frame and driven towards as a velocity: along the taught way, back to it from beside it, turned as it
/// was taught. So the robot need not stop at each model. With people about, it looks at its live depth first
/// (way_guard.h): it slows down, waits, and after `patience_s` looks for another way. Where it truly is may be another
/// place altogether once it was carried off, so it trusts its wheels for `blind_m` only, and then turns to look around.
/// So it does where it may be in several places that look the same and would not do the same in each of them.
///
/// The system acts, and ends the walk when it stands at its goal.

#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "algorithms/core/body_command.h"
#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/route_map.h"
#include "algorithms/core/taught_drive.h"
#include "algorithms/odometry/body_track.h"
#include "algorithms/slam/map_localizer.h"
#include "algorithms/slam/metric_sight.h"
#include "algorithms/slam/taught_ways.h"
#include "algorithms/slam/way_guard.h"

namespace gaitcam {

struct HybridDriveOptions {
  using DescribedTag = void;
  double goal_x_m = 0;
  double goal_y_m = 0;
  double speed_mps = 0.3;
  double lateral_gain = 1.0;
  double heading_gain = 1.5;
  double late_s = 0;
  double patience_s = 20;
  double blind_m = 1.5;
  MetricSightOptions sight;
  MapLocalizerOptions localizer;
  WayGuardOptions guard;
};

template <class Visitor>
void VisitFields(Visitor& visit, HybridDriveOptions& o) {
  visit("goal_x_m", o.goal_x_m, Between(-1000, 1000), "goal, ahead of where the map's robot started to learn it ...");
  visit("goal_y_m", o.goal_y_m, Between(-1000, 1000), "... and to the left of it");
  visit("speed_mps", o.speed_mps, Between(0.01, 3), "along the way where it is free");
  visit("lateral_gain", o.lateral_gain, Between(0, 10), "part of what it is beside the way that it drives back in 1 s");
  visit("heading_gain", o.heading_gain, Between(0, 10), "part of what it is turned too far that it turns back in 1 s");
  visit("late_s", o.late_s, Between(0, 10),
        "so late the body answers a command: wheels at once, legs after the steps under way");
  visit("patience_s", o.patience_s, Between(0, 36000), "so long it waits before it looks for another way");
  visit("blind_m", o.blind_m, Between(0.01, 1000),
        "so far it drives by its wheels alone; then it looks all around, once more that far on, and then it stands");
  VisitFields(visit, o.sight);
  VisitFields(visit, o.localizer);
  visit("guard", o.guard, Nested(), "what keeps it off people");
}

class HybridDrive {
 public:
  /// @throws BadInput if there is no map, it is of another camera, the goal is off the map, or the calibration has no
  /// depth or no odometry; BadOption.
  HybridDrive(const Calibration& calibration, std::shared_ptr<const RouteMap> map, const HybridDriveOptions& options,
              uint64_t seed);

  /// Poses are in the map's world. Those that no view of the map confirmed are predictions. @throws BadInput as
  /// MetricSight::See.
  FrameEstimate Track(const Observation& observation);
  const BodyCommand& command() const { return command_; }
  const TaughtDrive& drive() const { return drive_; }

 private:
  void Plan(const PlanarPose& X_FB);
  void PlanAround(const PlanarPose& X_FB);
  void Take(const std::vector<int>& views, const PlanarPose& X_FB);
  DriveState Drive(const DriveStep& step);
  Velocity Steer(const PlanarPose& X_FB, double speed_mps) const;
  std::vector<int> ViewsToGoal(const PlanarPose& X_FB) const;
  Route WayFrom(const PlanarPose& X_FB) const;
  bool KnowsTheWay(const PlanarPose& X_FB) const;
  bool Doubts(const DriveStep& step) const;
  bool LooksAround(const DriveStep& step);
  double GoingStill(int64_t stamp_ns);
  double SpeedBefore(double free_m) const;
  FrameEstimate AnswerOf(int64_t stamp_ns, const MetricModel& seen, const std::optional<MapLocalizer::Fix>& fix) const;

  HybridDriveOptions options_;
  MetricSight sight_;
  BodyTrack body_;
  MapLocalizer localizer_;
  WayGuard guard_;
  TaughtWays ways_;
  double frame_s_;  ///< Until it sees, and commands, again.
  std::shared_ptr<const RouteMap> map_;
  int goal_ = -1;  ///< View.
  Route route_;
  double along_m_ = 0;
  double blind_m_ = 0;  ///< Driven since it knew the way, or has looked around to find out.
  int looks_ = 0;       ///< Since then.
  std::optional<int64_t> looks_since_ns_;
  std::optional<int64_t> waits_since_ns_;
  std::deque<std::pair<int64_t, double>> commanded_;  ///< Stamps and speeds that the body may not have answered yet.
  BodyCommand command_ = Velocity();
  TaughtDrive drive_;
};

}  // namespace gaitcam
