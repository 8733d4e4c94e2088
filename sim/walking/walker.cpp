#include "sim/walking/walker.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/option_reader.h"
#include "algorithms/core/units.h"
#include "sim/walking/course.h"
#include "sim/walking/gait_plan.h"
#include "sim/walking/servo_feedforward.h"
#include "sim/walking/state_estimator.h"

namespace gaitcam {
namespace {

constexpr int kSolveIterations = 2;
constexpr double kMaxAnkleFeedback_rad = 0.3;
constexpr double kFade_s = 0.5;  ///< In which arms and neck begin and end to swing.

class Walker : public Controller {
 public:
  Walker(const Robot& robot, const mjModel* nominal, const GaitOptions& gait, const PathOptions& path,
         const PhysicsOptions& physics, const Pose& start)
      : robot_(robot),
        options_(ReadWalkerOptions(robot)),
        gait_(gait),
        path_(path),
        period_s_(physics.control_period_ms * 1e-3),
        plan_(PlanGait(robot, nominal, options_, gait, path, period_s_, start)),
        estimator_(robot, {options_.attitude_gain, options_.velocity_filter_s}, plan_.initial.X_PB),
        feedforward_(robot, gait.servo_stiffness, period_s_, options_.feedforward),
        head_pan_(robot),
        targets_(plan_.posture.joints()) {
    MoveNeck(0);
    initial_joints_ = targets_;
  }

  std::vector<double> InitialJoints() const override { return initial_joints_; }
  Pose InitialRoot() const override { return plan_.initial.X_PB; }
  GaitState gait() const override { return plan_.pattern.targets().gait; }

  bool Finished() const override {
    if (scan_.active()) return false;
    if (path_.kind == PathKind::kStand)
      return plan_.pattern.time() - scanned_s_ >= 2 * path_.settle_s + path_.duration_s;
    return std::holds_alternative<FollowPath>(wanted_) && wanted_ == served_ && !halting_ && plan_.pattern.Finished();
  }

  void Command(const BodyCommand& command) override {
    GAITCAM_ASSERT(!std::holds_alternative<gaitcam::Scan>(command));
    if (command == wanted_) return;
    wanted_ = command;
    if (const GoTo* to = std::get_if<GoTo>(&command))
      goal_ = Believed() * PlanarPose({to->x_m, to->y_m}, to->heading_rad);
  }

  void RequestScan(const HeadScanPlan& plan) override {
    plan_.pattern.Halt();
    scan_.Begin(plan, head_pan_.Of(targets_));
  }

  bool Scans() const override { return scan_.active(); }
  std::optional<double> SweepTurn() const override { return scan_.body_turn_rad(); }

  const std::vector<double>& Update(const ControlInput& input) override {
    Sense(input);
    if (!scan_.active() && (halting_ || wanted_ != served_)) ServeCommand();
    if (plan_.pattern.StepIsDue() && !course_.empty()) drift_ = course_.Take();
    const WalkTargets& plan = plan_.pattern.Advance(drift_);
    ShiftCenterOfMass(plan);
    Posture::Targets posture = plan.posture;
    posture.com += shift_;
    solution_ = plan_.posture.Solve(posture, kSolveIterations);
    MoveLegs(plan);
    AddFeedforward(plan);
    SwingArms(plan);
    if (scan_.active()) Scan();
    MoveNeck(plan_.pattern.time() - scanned_s_);
    return targets_;
  }

 private:
  /// The state by the sensors, and where the robot has gone since the last step began.
  void Sense(const ControlInput& input) {
    const WalkTargets& plan = plan_.pattern.targets();
    const bool single_support = plan.stance >= 0 && plan.load[size_t(plan.stance)] == 1;
    // Servos settle at first; then nothing moves, and what the gyroscope shows is its bias.
    const double time = plan_.pattern.time();
    const bool at_rest = time > 0.5 * path_.settle_s && time < path_.settle_s;
    estimator_.Update(input.imu, input.joints.position, period_s_, single_support ? plan.stance : -1, at_rest,
                      plan_.posture.mass_model());
    if (path_.feedback == PathFeedback::kNone || !solution_) return;
    GAITCAM_ASSERT(path_.feedback != PathFeedback::kTruth || input.X_WB.has_value());
    const Pose& measured = path_.feedback == PathFeedback::kTruth ? *input.X_WB : estimator_.X_OB();
    course_.Add(PlanarPose(measured), PlanarPose(solution_->X_PB));
  }

  /// Where the robot believes to stand, in W.
  PlanarPose Believed() const { return drift_.X_WP * PlanarPose(solution_ ? solution_->X_PB : plan_.initial.X_PB); }

  static bool Stands(const BodyCommand& command) { return command == BodyCommand(Velocity()); }

  /// One velocity follows another as it walks; from anything else to anything else it stands in between.
  void ServeCommand() {
    const Velocity* velocity = std::get_if<Velocity>(&wanted_);
    const bool walks_at_velocity = std::holds_alternative<Velocity>(served_) && !Stands(served_) && !halting_;
    if (velocity && !Stands(wanted_) && walks_at_velocity) {
      plan_.pattern.ChangeVelocity(*velocity);
      served_ = wanted_;
      return;
    }
    if (!halting_) plan_.pattern.Halt();
    halting_ = true;
    if (!plan_.pattern.Halted()) return;
    halting_ = false;
    served_ = wanted_;
    if (!course_.empty()) drift_ = course_.Take();
    if (std::holds_alternative<FollowPath>(wanted_)) plan_.pattern.FollowPath(drift_);
    if (std::holds_alternative<GoTo>(wanted_)) plan_.pattern.GoTo(goal_, drift_);
    if (velocity && !Stands(wanted_)) plan_.pattern.Walk(*velocity, drift_);
  }

  /// What the scan asks of the feet.
  void Scan() {
    const HeadScan::Order order = scan_.Advance(period_s_, plan_.pattern.Halted(), estimator_.X_OB().Yaw());
    scanned_s_ += period_s_;
    if (order.kind == HeadScan::Order::Kind::kNone) return;
    if (!course_.empty()) drift_ = course_.Take();
    halting_ = false;
    if (order.kind == HeadScan::Order::Kind::kTurn) {
      plan_.pattern.TurnOnTheSpot(order.turn_rad, drift_);
    } else if (!Stands(served_)) {
      plan_.pattern.GoOn(drift_);
    }
  }

  /// Moves the centre of mass against the error of the divergent component of motion: where the robot would fall to.
  void ShiftCenterOfMass(const WalkTargets& plan) {
    Eigen::Vector2d wanted(0, 0);
    if (plan.gait.step > plan_.pattern.first_step()) {
      const ComOverFoot& com = estimator_.com_over_foot(plan.stance);
      const Eigen::Vector2d measured = com.position + com.velocity / plan_.natural_frequency;
      const PlanarPose X_PA(plan.posture.X_PA[size_t(plan.stance)]);
      const Eigen::Vector2d error = measured - X_PA.Inverse() * plan.dcm;
      wanted = -options_.dcm_gain * (PlanarPose({0, 0}, X_PA.heading) * error);
    }
    shift_ += std::min(1.0, period_s_ / options_.dcm_filter_s) * (wanted - shift_);
    shift_ = shift_.cwiseMax(-options_.dcm_limit_m).cwiseMin(options_.dcm_limit_m);
  }

  /// Solved angles, and on top of them: the standing ankle leans against the trunk's tilt, the swinging one levels its
  /// sole.
  void MoveLegs(const WalkTargets& plan) {
    const Eigen::Vector2d tilt(estimator_.roll(), estimator_.pitch() - options_.lean_rad);
    const Eigen::Vector2d rate = estimator_.angular_rate().head<2>();
    const Eigen::Vector2d angle_gain(options_.roll_gain, options_.pitch_gain);
    const Eigen::Vector2d rate_gain(options_.roll_rate_gain, options_.pitch_rate_gain);
    for (int side = 0; side < 2; ++side) {
      const double turned = PlanarPose(plan.posture.X_PA[size_t(side)]).heading - plan.posture.heading;
      const PlanarPose foot_from_root({0, 0}, -turned);
      const double load = plan.load[size_t(side)];
      const double swing = plan.stance >= 0 && side != plan.stance ? std::min(1.0, 5 * plan.swing_phase) : 0.0;
      Eigen::Vector2d correction = load * (angle_gain.cwiseProduct(tilt) + rate_gain.cwiseProduct(rate));
      correction -= swing * options_.leveling_gain * tilt;
      correction = foot_from_root * correction;
      LegAngles angles = solution_->legs[size_t(side)].angles;
      angles[5] += std::clamp(correction.x(), -kMaxAnkleFeedback_rad, kMaxAnkleFeedback_rad);
      angles[4] += std::clamp(correction.y(), -kMaxAnkleFeedback_rad, kMaxAnkleFeedback_rad);
      plan_.posture.leg(side).ToJoints(angles, targets_);
    }
  }

  /// The planned force of the floor on each foot: along the line from the ZMP to the centre of mass.
  void AddFeedforward(const WalkTargets& plan) {
    const Eigen::Vector3d pull(plan.acceleration.x(), plan.acceleration.y(), kGravity);
    std::array<MassModel::Contact, 2> contacts;
    for (int side = 0; side < 2; ++side) {
      const LegKinematics& leg = plan_.posture.leg(side);
      const Pose X_BA = leg.Forward(solution_->legs[size_t(side)].angles);
      contacts[side].point = X_BA * Eigen::Vector3d(leg.sole().x() + options_.zmp_forward_m,
                                                    -SideSign(side) * options_.zmp_inward_m, leg.sole().z());
      contacts[side].force =
          solution_->X_PB.rotation.conjugate() * (plan_.posture.mass_model().mass() * plan.load[size_t(side)] * pull);
    }
    const std::vector<double> torques = plan_.posture.mass_model().HoldingTorques(
        contacts, {plan_.posture.leg(0).joints(), plan_.posture.leg(1).joints()});
    const std::vector<double>& offsets = feedforward_.Update(plan_.posture.joints(), torques);
    for (size_t j = 0; j < offsets.size(); ++j) targets_[j] += offsets[j];
  }

  /// Each arm goes with the other side's leg.
  void SwingArms(const WalkTargets& plan) {
    if (gait_.arm_swing_rad == 0) return;
    const bool walking = plan.stance >= 0;
    arm_fade_ += (period_s_ / kFade_s) * ((walking ? 1.0 : 0.0) - arm_fade_);
    if (walking) arm_phase_ = plan.gait.step % 2 + plan.gait.phase;  // even steps swing the left foot forward
    const double left_back = -gait_.arm_swing_rad * arm_fade_ * std::cos(kPi * arm_phase_);
    SetJoint(robot_.shoulders[0], left_back, 1);
    SetJoint(robot_.shoulders[1], -left_back, 1);
  }

  void MoveNeck(double time) {
    double pan = 0;
    if (scan_.active()) {
      pan = scan_.pan_rad();
    } else if (path_.kind == PathKind::kStand) {
      const double since = std::max(0.0, time - path_.settle_s), left = std::max(0.0, path_.duration_s - since);
      const double fade = std::clamp(std::min(since, left) / kFade_s, 0.0, 1.0);
      pan = fade * path_.pan_amplitude_rad * std::sin(2 * kPi * since / path_.pan_period_s);
    }
    head_pan_.Set(pan, targets_);
    SetJoint(robot_.neck_tilt, path_.head_tilt_rad, 1);
  }

  /// `angle` about the positive axis (0 x, 1 y, 2 z) of the trunk, whatever the sense in which the joint counts.
  void SetJoint(int joint, double angle, int axis) {
    if (joint < 0) return;
    const RobotJoint& j = robot_.joints[size_t(joint)];
    const double target = j.axis[axis] < 0 ? -angle : angle;
    const bool endless = j.kind == RobotJoint::Kind::kContinuous;
    targets_[size_t(joint)] = endless ? target : std::clamp(target, j.lower, j.upper);
  }

  Robot robot_;
  WalkerOptions options_;
  GaitOptions gait_;
  PathOptions path_;
  double period_s_;
  GaitPlan plan_;
  StateEstimator estimator_;
  ServoFeedforward feedforward_;
  HeadPan head_pan_;
  HeadScan scan_;
  double scanned_s_ = 0;  ///< In all scans so far: standing with a swinging neck goes on as if they had not been.
  BodyCommand wanted_, served_;  ///< Between the two it comes to stand.
  bool halting_ = false;         ///< It was told to halt for the wanted command.
  PlanarPose goal_;              ///< Of the wanted GoTo, in W.
  std::vector<double> targets_, initial_joints_;
  std::optional<Posture::Solution> solution_;
  Course course_;
  PlanDrift drift_;
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();
  double arm_fade_ = 0, arm_phase_ = 0;
};

}  // namespace

WalkerOptions ReadWalkerOptions(const Robot& robot) {
  WalkerOptions options;
  OptionOrigin origin;
  origin.file = robot.yaml_file.string();
  OptionValue control = OptionValue::Map({}, origin).WithPath("control");
  for (const auto& [key, value] : robot.control) control.Set(key, OptionValue(value).WithOrigin(control.origin()));
  ReadOption(control, options);
  return options;
}

std::unique_ptr<Controller> MakeWalker(const Robot& robot, const mjModel* nominal, const GaitOptions& gait,
                                       const PathOptions& path, const PhysicsOptions& physics, const Pose& start) {
  CheckGait(robot, nominal, gait, path, physics);
  return std::make_unique<Walker>(robot, nominal, gait, path, physics, start);
}

double EstimateWalkingTime(const GaitOptions& gait, const PathOptions& path) {
  if (path.kind == PathKind::kStand) return 2 * path.settle_s + path.duration_s;
  FootstepPlanner planner(gait, {}, Path(path, {}));
  while (!planner.complete()) planner.Append({}, planner.count());
  return 2 * path.settle_s + (planner.count() - 2) * gait.period_s;
}

}  // namespace gaitcam
