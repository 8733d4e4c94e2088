#include "sim/walking/head_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr double kAcceleration_rad_s2 = 6;  ///< Of the head; its servos follow this without overshoot.

double HalfView(const CameraModel& camera) { return std::atan(0.5 * camera.width_px / camera.fx); }

int Degrees(double rad) { return int(std::lround(rad * 180 / kPi)); }

}  // namespace

HeadPan::HeadPan(const Robot& robot) {
  for (const int index : {robot.neck_pan, robot.camera_pan}) {
    if (index < 0) continue;
    const RobotJoint& j = robot.joints[size_t(index)];
    const bool endless = j.kind == RobotJoint::Kind::kContinuous;
    const double lower = endless ? -kPi : j.lower, upper = endless ? kPi : j.upper;
    const double reach = std::max(0.0, std::min(-lower, upper));
    joints_.push_back({index, j.axis.z() < 0 ? -1.0 : 1.0, reach, lower, upper});
    reach_rad_ += reach;
  }
}

double HeadPan::Of(const std::vector<double>& joints) const {
  double pan = 0;
  for (const Joint& joint : joints_) pan += joint.sign * joints[size_t(joint.index)];
  return pan;
}

void HeadPan::Set(double pan_rad, std::vector<double>& joints) const {
  for (const Joint& joint : joints_) {
    const double share = joints_.size() == 1 ? 1 : joint.reach_rad / reach_rad_;
    joints[size_t(joint.index)] = std::clamp(joint.sign * share * pan_rad, joint.lower, joint.upper);
  }
}

HeadScanPlan PlanHeadScan(const Robot& robot, const HeadScanOptions& options, const CameraModel& camera,
                          double exposure_s) {
  CheckFields(options, "scan.");
  const double reach = HeadPan(robot).reach_rad(), half_view = HalfView(camera);
  if (reach + half_view < kPi / 2) {
    throw BadOption(
        fmt::format("scan: {} cannot look all around: its head pans by {} degrees to each side; expected at "
                    "least {} with this camera",
                    robot.name, Degrees(reach), Degrees(kPi / 2 - half_view)));
  }
  HeadScanPlan plan;
  plan.options = options;
  plan.sweeps = reach + half_view >= kPi ? 1 : 2;
  plan.to_rad = std::min(reach, plan.sweeps == 1 ? kPi : kPi / 2);
  plan.speed_rad_s = options.speed_rad_s;
  if (exposure_s > 0) plan.speed_rad_s = std::min(plan.speed_rad_s, options.blur_px / (camera.fx * exposure_s));
  return plan;
}

void HeadScan::Begin(const HeadScanPlan& plan, double pan_rad) {
  GAITCAM_ASSERT(!active());
  const HeadScanOptions& o = plan.options;
  const Stage stand{Kind::kStand, o.settle_s};
  const double left = plan.to_rad, right = -plan.to_rad;
  stages_ = {stand, {Kind::kMove, left, o.approach_rad_s}, stand, {Kind::kSweep, right, plan.speed_rad_s}};
  if (plan.sweeps == 2) {
    stages_.insert(stages_.end(), {{Kind::kTurn, kPi}, stand, {Kind::kSweep, left, plan.speed_rad_s}});
  }
  stages_.push_back({Kind::kMove, pan_rad, o.approach_rad_s});
  if (plan.sweeps == 2) stages_.insert(stages_.end(), {{Kind::kTurn, -kPi}, stand});
  stage_ = 0;
  pan_rad_ = pan_rad;
  heading_rad_.reset();
  turned_rad_ = 0;
  Enter();
}

void HeadScan::Enter() {
  since_s_ = 0;
  from_rad_ = pan_rad_;
  if (!active()) return;
  const Stage& stage = stages_[stage_];
  profile_ = SmoothProfile(std::abs(stage.value - pan_rad_), stage.speed_rad_s, kAcceleration_rad_s2);
}

void HeadScan::FollowHeading(double heading_rad) {
  if (heading_rad_) turned_rad_ += std::remainder(heading_rad - *heading_rad_, 2 * kPi);
  heading_rad_ = heading_rad;
}

HeadScan::Order HeadScan::Advance(double period_s, bool stands, double heading_rad) {
  GAITCAM_ASSERT(active());
  const Stage stage = stages_[stage_];
  if (stands && !heading_rad_) FollowHeading(heading_rad);
  if (heading_rad_) FollowHeading(heading_rad);
  bool done = true;
  if (stage.kind == Kind::kStand) {
    since_s_ = stands ? since_s_ + period_s : 0;
    done = since_s_ > stage.value;
  } else if (stage.kind != Kind::kTurn) {
    since_s_ += period_s;
    pan_rad_ = from_rad_ + std::copysign(profile_.Position(since_s_), stage.value - from_rad_);
    done = since_s_ >= profile_.duration_s();
  }
  // The heading at a sweep's start is kept for all of it: the feet do not move, but the gyroscope drifts.
  const bool sweeps = stage.kind == Kind::kSweep && !done;
  if (!sweeps) body_turn_rad_.reset();
  if (sweeps && !body_turn_rad_) body_turn_rad_ = turned_rad_;
  if (!done) return {};
  ++stage_;
  Enter();
  if (!active()) return {Order::Kind::kGoOn, 0};
  if (stage.kind == Kind::kTurn) return {Order::Kind::kTurn, stage.value};
  return {};
}

}  // namespace gaitcam
