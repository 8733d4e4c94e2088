/// Looking all around while standing: how the head sweeps, and how often the body turns on the spot between.
///
/// Two ways, by what the head can do. One that reaches far enough sweeps once from its left limit to its right one. Any
/// other sweeps half of the circle; the body turns by 180 degrees, the head sweeps the other half, the body turns back.

#pragma once

#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "models/robot.h"
#include "sim/smooth_profile.h"

namespace gaitcam {

struct HeadScanOptions {
  using DescribedTag = void;
  double speed_rad_s = 0.8;     ///< Of a sweep, at most.
  double blur_px = 1.3;         ///< Sweeps go slower if the image's middle would move further during one exposure.
  double approach_rad_s = 1.6;  ///< Speed of the head to where a sweep begins, and back at the end.
  double settle_s = 0.6;        ///< Standing still before the head moves, and the head before each sweep.
};

template <class Visitor>
void VisitFields(Visitor& visit, HeadScanOptions& o) {
  visit("speed_rad_s", o.speed_rad_s, Between(0.01, 6.0), "of a sweep of the head, at most");
  visit("blur_px", o.blur_px, Between(0.01, 1000.0), "slower if the image moved further during one exposure");
  visit("approach_rad_s", o.approach_rad_s, Between(0.01, 6.0), "of the head to where a sweep begins");
  visit("settle_s", o.settle_s, Between(0.0, 60.0), "standing still before the head moves and before it sweeps");
}

/// The head's pan by joints that turn the camera about the vertical: the neck's and the camera's own. Left is positive.
class HeadPan {
 public:
  explicit HeadPan(const Robot& robot);
  /// How far the camera turns to either side, rad; 0 without such joints.
  double reach_rad() const { return reach_rad_; }
  /// By joint positions in the order of Robot::joints.
  double Of(const std::vector<double>& joints) const;
  /// Shares a pan out between the joints, in proportion to their reach.
  void Set(double pan_rad, std::vector<double>& joints) const;

 private:
  struct Joint {
    int index = -1;
    double sign = 1, reach_rad = 0, lower = 0, upper = 0;
  };
  std::vector<Joint> joints_;
  double reach_rad_ = 0;
};

struct HeadScanPlan {
  HeadScanOptions options;
  int sweeps = 1;     ///< 1, or 2 with a turn on the spot between.
  double to_rad = 0;  ///< A sweep leads from here to as far on the other side.
  double speed_rad_s = 0;
};

/// What a robot with this camera has to do to see all around. @param exposure_s sets the speed, see HeadScanOptions.
/// @throws BadOption naming the robot, its reach and the least that would do.
HeadScanPlan PlanHeadScan(const Robot& robot, const HeadScanOptions& options, const CameraModel& camera,
                          double exposure_s);

/// A scan as it goes: what head and feet have to do next.
class HeadScan {
 public:
  /// What the feet are asked.
  struct Order {
    enum class Kind { kNone, kTurn, kGoOn };
    Kind kind = Kind::kNone;
    double turn_rad = 0;
  };

  bool active() const { return stage_ < stages_.size(); }
  /// @param pan_rad where the head looks, and will look again at the end. @pre not active.
  void Begin(const HeadScanPlan& plan, double pan_rad);
  /// One control period of an active scan. @param stands both feet are down for good. @param heading_rad of the body as
  /// it believes itself.
  Order Advance(double period_s, bool stands, double heading_rad);

  double pan_rad() const { return pan_rad_; }
  /// While the head sweeps: how far the body believes to have turned since the scan began.
  std::optional<double> body_turn_rad() const { return body_turn_rad_; }

 private:
  enum class Kind { kStand, kMove, kSweep, kTurn };
  struct Stage {
    Kind kind;
    double value = 0;  ///< kStand: s. kMove, kSweep: pan in rad at the end. kTurn: rad.
    double speed_rad_s = 0;
  };

  void Enter();
  void FollowHeading(double heading_rad);

  std::vector<Stage> stages_;
  size_t stage_ = 0;
  double since_s_ = 0, from_rad_ = 0, pan_rad_ = 0;
  SmoothProfile profile_;
  std::optional<double> heading_rad_, body_turn_rad_;
  double turned_rad_ = 0;  ///< Since the scan began.
};

}  // namespace gaitcam
