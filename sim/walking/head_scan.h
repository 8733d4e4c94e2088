/// A scan of the full circle while standing: sweeps of the head, with turns of the body on the spot between them.
///
/// Its course depends on the head's range. If the range suffices, one sweep from the left limit to the right one covers
/// the circle. Otherwise the head sweeps half of it, the body turns by 180 degrees, the head sweeps the other half, and
/// the body turns back.

#pragma once

#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "models/code/robots/robot.h"
#include "sim/walking/smooth_profile.h"

namespace gaitcam {

struct HeadScanOptions {
  using DescribedTag = void;
  double speed_rad_s = 0.8;
  double blur_px =
      1.3;  ///< Limit on the motion of the image's centre during one exposure; sweeps are slowed to meet it.
  double approach_rad_s = 1.6;
  double settle_s = 0.6;
};

template <class Visitor>
void VisitFields(Visitor& visit, HeadScanOptions& o) {
  visit("speed_rad_s", o.speed_rad_s, Between(0.01, 6.0), "of a sweep of the head, at most");
  visit("blur_px", o.blur_px, Between(0.01, 1000.0),
        "sweeps go slower where the image's middle would move further during one exposure");
  visit("approach_rad_s", o.approach_rad_s, Between(0.01, 6.0),
        "speed of the head to where a sweep begins, and back at the end");
  visit("settle_s", o.settle_s, Between(0.0, 60.0),
        "standing still before the head moves, and the head before each sweep");
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

/// Plans a scan of the full circle for a robot with this camera. @param exposure_s sets the speed, see HeadScanOptions.
/// @throws BadOption naming the robot, the reach of its head and the minimum needed.
HeadScanPlan PlanHeadScan(const Robot& robot, const HeadScanOptions& options, const CameraModel& camera,
                          double exposure_s);

/// The state of a scan in progress: commands for head and feet, one control period at a time.
class HeadScan {
 public:
  /// Command to the feet.
  struct Order {
    enum class Kind { kNone, kTurn, kGoOn };
    Kind kind = Kind::kNone;
    double turn_rad = 0;
  };

  bool active() const { return stage_ < stages_.size(); }
  /// @param pan_rad the head's pan before the scan, restored at its end. @pre not active.
  void Begin(const HeadScanPlan& plan, double pan_rad);
  /// One control period of an active scan. @param stands both feet are down for good. @param heading_rad of the body as
  /// it believes itself.
  Order Advance(double period_s, bool stands, double heading_rad);

  double pan_rad() const { return pan_rad_; }
  /// During a sweep: the body's estimated turn since the scan began.
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
