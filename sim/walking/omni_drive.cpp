#include "sim/walking/omni_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algorithms/core/errors.h"
#include "sim/walking/hand_sway.h"

namespace gaitcam {

namespace {

using std::numbers::pi;

/// Segments that are driven without a stop, or one turn on the spot.
struct Stretch {
  std::vector<PathSegment> segments;
  SmoothProfile profile;
};

std::vector<Stretch> PlanStretches(const Path& path, const OmniDriveOptions& options) {
  std::vector<Stretch> stretches;
  for (const PathSegment& segment : path.segments()) {
    const bool goes_on =
        !stretches.empty() && !segment.IsTurnOnTheSpot() && !stretches.back().segments.back().IsTurnOnTheSpot();
    if (!goes_on) stretches.emplace_back();
    stretches.back().segments.push_back(segment);
  }
  for (Stretch& stretch : stretches) {
    double length = 0;
    for (const PathSegment& segment : stretch.segments) length += segment.length_m;
    const double turn = std::abs(stretch.segments[0].turn_rad);
    stretch.profile = length > 0 ? SmoothProfile(length, options.speed_mps, options.acceleration_mps2)
                                 : SmoothProfile(turn, options.turn_rate_rad_s, options.turn_acceleration_rad_s2);
  }
  return stretches;
}

struct Reference {
  PlanarPose pose;
  double speed_ratio = 0;  ///< Of the greatest speed along the path.
};

double DurationOf(const std::vector<Stretch>& stretches) {
  double duration = 0;
  for (const Stretch& stretch : stretches) duration += stretch.profile.duration_s();
  return duration;
}

/// What the base does beside its path, by command: it drives at a velocity, or a route to a goal.
class Excursion {
 public:
  Excursion(const OmniDriveOptions& options, const PlanarPose& from) : options_(options), pose_(from) {}

  /// @param pace of the time on a route, 0 to 1.
  void Advance(const Velocity& wanted, double pace, double period_s) {
    if (OnRoute()) {
      route_s_ += pace * period_s;
      const PlanarPose next = RouteAt(route_s_), step = pose_.Inverse() * next;
      velocity_ = {step.position.x() / period_s, step.position.y() / period_s, step.heading / period_s};
      pose_ = next;
      if (route_s_ >= DurationOf(route_)) EndRoute();
      return;
    }
    Approach(wanted, period_s);
    pose_ = Ahead(period_s);
  }
  /// From here on at the velocity that it has.
  void LeaveRoute() {
    route_.clear();
    goal_.reset();
  }
  /// @pre Stands().
  void GoTo(const PlanarPose& goal) {
    goal_ = goal;
    route_ = PlanStretches(Path::ToGoal(pose_, goal), options_);
    route_s_ = 0;
    if (route_.empty()) EndRoute();
  }
  /// Where it will be after `time_s` if nothing else is commanded.
  PlanarPose Ahead(double time_s) const {
    if (OnRoute()) return RouteAt(route_s_ + time_s);
    return pose_ *
           PlanarPose({velocity_.forward_mps * time_s, velocity_.left_mps * time_s}, velocity_.turn_rad_s * time_s);
  }
  bool OnRoute() const { return goal_.has_value(); }
  bool Stands() const { return !OnRoute() && velocity_ == Velocity(); }
  double SpeedRatio() const { return std::hypot(velocity_.forward_mps, velocity_.left_mps) / options_.speed_mps; }
  const PlanarPose& pose() const { return pose_; }

 private:
  void EndRoute() {
    pose_ = {goal_->position, pose_.heading + WrapAngle(goal_->heading - pose_.heading)};
    velocity_ = {};
    LeaveRoute();
  }

  /// Towards what is wanted, clamped to what the base can do.
  void Approach(const Velocity& wanted, double period_s) {
    Eigen::Vector2d to(wanted.forward_mps, wanted.left_mps), now(velocity_.forward_mps, velocity_.left_mps);
    if (to.norm() > options_.speed_mps) to *= options_.speed_mps / to.norm();
    const double turn = std::clamp(wanted.turn_rad_s, -options_.turn_rate_rad_s, options_.turn_rate_rad_s);
    const Eigen::Vector2d change = to - now;
    const double most = options_.acceleration_mps2 * period_s, max_turn = options_.turn_acceleration_rad_s2 * period_s;
    now = change.norm() > most ? Eigen::Vector2d(now + change * (most / change.norm())) : to;
    velocity_ = {now.x(), now.y(), std::clamp(turn, velocity_.turn_rad_s - max_turn, velocity_.turn_rad_s + max_turn)};
  }

  PlanarPose RouteAt(double t) const {
    for (const Stretch& stretch : route_) {
      const double duration = stretch.profile.duration_s();
      if (t >= duration) {
        t -= duration;
        continue;
      }
      const PathSegment& segment = stretch.segments[0];  // a goal is reached by single lines and turns
      const double s = stretch.profile.Position(t);
      if (!segment.IsTurnOnTheSpot()) return segment.At(s);
      return {segment.start.position, segment.start.heading + std::copysign(s, segment.turn_rad)};
    }
    return route_.empty() ? pose_ : route_.back().segments.back().end();
  }

  OmniDriveOptions options_;
  PlanarPose pose_;
  Velocity velocity_;
  std::optional<PlanarPose> goal_;
  std::vector<Stretch> route_;
  double route_s_ = 0;
};

class OmniDrive : public Controller {
 public:
  OmniDrive(const Robot& robot, const OmniDriveOptions& options, const PathOptions& path_options, const Pose& start,
            uint64_t seed)
      : robot_(robot),
        options_(options),
        path_options_(path_options),
        path_(path_options, start),
        sway_(robot, options.speed_mps, seed),
        head_pan_(robot) {
    CheckFields(options, "drive.");
    stretches_ = PlanStretches(path_, options);
    for (const Stretch& stretch : stretches_) moving_s_ += stretch.profile.duration_s();
    if (stretches_.empty()) moving_s_ = path_options.duration_s;
    // A damped servo trails a moving target by damping / stiffness: 2 zeta / omega seconds. It is told that much ahead.
    lead_s_ = 2 * robot.drive.damping_ratio / (2 * pi * robot.drive.frequency_hz);
    targets_.assign(robot.joints.size() + 5, 0.0);
  }

  std::vector<double> InitialJoints() const override {
    std::vector<double> joints = JointsAtRest();
    sway_.AddTo(joints, 0, 0);
    return joints;
  }

  Pose InitialRoot() const override { return path_.start().Lifted(robot_.base_height_m); }

  const std::vector<double>& Update(const ControlInput& input) override {
    const double now_s = 1e-9 * double(input.stamp_ns), period_s = now_s - clock_s_;
    clock_s_ = now_s;
    if (scan_.active() || pace_ < 1 || LeavesPath()) Scan(period_s);
    if (excursion_) Drive(period_s);
    time_s_ = now_s - halted_s_;
    const std::vector<double> joints = JointsAtRest();
    std::copy(joints.begin(), joints.end(), targets_.begin());
    PanNeck();
    const Reference ahead =
        excursion_ ? Reference{excursion_->Ahead(lead_s_), excursion_->SpeedRatio()} : At(time_s_ + lead_s_);
    sway_.AddTo(targets_, time_s_, ahead.speed_ratio * Speed());
    const size_t n = robot_.joints.size();
    targets_[n] = ahead.pose.position.x();
    targets_[n + 1] = ahead.pose.position.y();
    targets_[n + 2] = ahead.pose.heading + Spot();
    const double amplitude = options_.vibration_amplitude_rad * ahead.speed_ratio * Speed();
    const double phase = 2 * pi * options_.vibration_hz * time_s_;
    targets_[n + 3] = amplitude * std::sin(phase);
    targets_[n + 4] = amplitude * std::sin(0.83 * phase);
    return targets_;
  }

  GaitState gait() const override { return {}; }
  bool Finished() const override { return !scan_.active() && !LeavesPath() && time_s_ >= duration_s(); }

  void Command(const BodyCommand& command) override {
    GAITCAM_ASSERT(!std::holds_alternative<gaitcam::Scan>(command));
    if (command == wanted_) return;
    wanted_ = command;
    planned_ = false;
    if (const GoTo* to = std::get_if<GoTo>(&command)) goal_ = Here() * PlanarPose({to->x_m, to->y_m}, to->heading_rad);
  }

  void Hold(const PlanarPose& pose) override {
    const double heading = Here().heading;  // not wrapped, and so are the servo's targets
    excursion_.emplace(options_, PlanarPose(pose.position, heading + WrapAngle(pose.heading - heading)));
    planned_ = false;
  }

  void RequestScan(const HeadScanPlan& plan) override { scan_.Begin(plan, head_pan_.Of(targets_)); }
  bool Scans() const override { return scan_.active(); }
  std::optional<double> SweepTurn() const override { return scan_.body_turn_rad(); }

  double duration_s() const { return moving_s_ + 2 * path_options_.settle_s; }

  /// On its path, if it was never commanded.
  PlanarPose PlannedAt(double time_s) const { return At(time_s).pose; }

 private:
  PlanarPose Here() const { return excursion_ ? excursion_->pose() : At(time_s_).pose; }

  std::vector<double> JointsAtRest() const {
    std::vector<double> joints(robot_.joints.size(), 0.0);
    if (robot_.neck_tilt >= 0) joints[size_t(robot_.neck_tilt)] = path_options_.head_tilt_rad;
    return joints;
  }

  /// 1 on its way, 0 while halted, a raised cosine between.
  double Speed() const { return 0.5 - 0.5 * std::cos(pi * pace_); }

  /// What turns on the spot have added to the heading.
  double Spot() const { return spot_from_rad_ + std::copysign(spot_.Position(spot_s_), spot_turn_rad_); }

  /// To halt, the time on the path slows down; turns on the spot add up. Its wheels are taken at their word.
  void Scan(double period_s) {
    const double ramp_s = pi * options_.speed_mps / (2 * options_.acceleration_mps2);
    const bool halts = scan_.active() || (LeavesPath() && !excursion_);
    pace_ = std::clamp(pace_ + (halts ? -1 : 1) * period_s / ramp_s, 0.0, 1.0);
    halted_s_ += excursion_ ? period_s : (1 - Speed()) * period_s;
    if (LeavesPath() && !excursion_ && (pace_ == 0 || RestsOnPath())) {
      pace_ = 0;
      excursion_.emplace(options_, At(time_s_).pose);
    }
    spot_s_ += period_s;
    if (!scan_.active()) return;
    const bool stands =
        pace_ == 0 && spot_s_ > spot_.duration_s() && (!excursion_ || excursion_->OnRoute() || excursion_->Stands());
    const HeadScan::Order order = scan_.Advance(period_s, stands, Spot());
    if (order.kind != HeadScan::Order::Kind::kTurn) return;
    spot_from_rad_ += spot_turn_rad_;
    spot_turn_rad_ = order.turn_rad;
    spot_ = SmoothProfile(std::abs(spot_turn_rad_), options_.turn_rate_rad_s, options_.turn_acceleration_rad_s2);
    spot_s_ = 0;
  }

  /// Before the path's begin and after its end.
  bool RestsOnPath() const {
    const double t = time_s_ + lead_s_ - path_options_.settle_s;
    return t <= 0 || t - lead_s_ >= moving_s_;
  }

  /// Something else is to be done than to follow the path, or it has not come back to it yet.
  bool LeavesPath() const { return excursion_.has_value() || !std::holds_alternative<FollowPath>(wanted_); }

  /// One control period beside the path. A goal is planned from where the base stands; the way back ends where the path
  /// was left.
  void Drive(double period_s) {
    const Velocity* velocity = std::get_if<Velocity>(&wanted_);
    if (!planned_) excursion_->LeaveRoute();
    const bool drives = velocity != nullptr && !scan_.active();
    excursion_->Advance(drives ? *velocity : Velocity(), Speed(), period_s);
    if (velocity != nullptr) {
      planned_ = true;
    } else if (!planned_ && excursion_->Stands()) {
      excursion_->GoTo(std::holds_alternative<GoTo>(wanted_) ? goal_ : At(time_s_).pose);
      planned_ = true;
    } else if (std::holds_alternative<FollowPath>(wanted_) && planned_ && !excursion_->OnRoute() && !scan_.active()) {
      excursion_.reset();
      pace_ = 0;
    }
  }

  void PanNeck() {
    if (scan_.active()) {
      head_pan_.Set(scan_.pan_rad(), targets_);
      return;
    }
    const double t = time_s_ - path_options_.settle_s;
    if (path_options_.kind != PathKind::kStand || robot_.neck_pan < 0 || t < 0 || t > moving_s_) return;
    targets_[size_t(robot_.neck_pan)] =
        path_options_.pan_amplitude_rad * std::sin(2 * pi * t / path_options_.pan_period_s);
  }

  Reference At(double time) const {
    double t = time - path_options_.settle_s;
    if (stretches_.empty() || t <= 0) return {path_.start(), 0};
    for (const Stretch& stretch : stretches_) {
      if (t < stretch.profile.duration_s()) return On(stretch, t);
      t -= stretch.profile.duration_s();
    }
    return {path_.goal(), 0};
  }

  Reference On(const Stretch& stretch, double t) const {
    double s = stretch.profile.Position(t);
    const PathSegment& first = stretch.segments[0];
    if (first.IsTurnOnTheSpot()) {
      return {PlanarPose(first.start.position, first.start.heading + std::copysign(s, first.turn_rad)), 0};
    }
    const double ratio = stretch.profile.Speed(t) / options_.speed_mps;
    for (const PathSegment& segment : stretch.segments) {
      if (s <= segment.length_m || &segment == &stretch.segments.back()) return {segment.At(s), ratio};
      s -= segment.length_m;
    }
    return {stretch.segments.back().end(), ratio};
  }

  Robot robot_;
  OmniDriveOptions options_;
  PathOptions path_options_;
  Path path_;
  std::vector<Stretch> stretches_;
  std::vector<double> targets_;
  double moving_s_ = 0, lead_s_ = 0, time_s_ = 0;
  HandSway sway_;
  HeadPan head_pan_;
  HeadScan scan_;
  BodyCommand wanted_;
  bool planned_ = false;  ///< The wanted command's route is planned, or its velocity is driven.
  PlanarPose goal_;       ///< Of the wanted GoTo.
  std::optional<Excursion> excursion_;
  double clock_s_ = 0, halted_s_ = 0;  ///< Time that scans and excursions have taken.
  double pace_ = 1;                    ///< Of the time on the path, before it is rounded off.
  SmoothProfile spot_;                 ///< The present turn of a scan, ...
  double spot_turn_rad_ = 0, spot_s_ = 0, spot_from_rad_ = 0;
};

}  // namespace

double EstimateDrivingTime(const OmniDriveOptions& options, const PathOptions& path) {
  return OmniDrive(Robot{}, options, path, Pose(), 0).duration_s();
}

std::function<PlanarPose(double)> PlanDriving(const OmniDriveOptions& options, const PathOptions& path,
                                              const Pose& start) {
  const auto drive = std::make_shared<const OmniDrive>(Robot{}, options, path, start, 0);
  return [drive](double time_s) { return drive->PlannedAt(time_s); };
}

std::unique_ptr<Controller> MakeOmniDrive(const Robot& robot, const OmniDriveOptions& options, const PathOptions& path,
                                          const Pose& start, uint64_t seed) {
  GAITCAM_ASSERT(robot.kind == Robot::Kind::kOmniBase);
  return std::make_unique<OmniDrive>(robot, options, path, start, seed);
}

}  // namespace gaitcam
