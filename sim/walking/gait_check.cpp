// Declared in sim/walking/walker.h: rejects a gait before the run by planning its steps without physics, then
// identifies the parameter responsible: with it at a harmless value the gait is feasible, and bisection finds its
// limit.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "algorithms/core/errors.h"
#include "sim/walking/gait_plan.h"

namespace gaitcam {
namespace {

constexpr int kMinSwingTicks = 10;
constexpr double kFootClearance_m = 0.002;
constexpr int kBisections = 12;

std::string Number(double value) { return fmt::format("{:.3g}", value); }

/// Both soles as seen from above, at their closest: one turned against the other by `turn` while side by side.
double NarrowestSpacing(const LegKinematics& left, double turn) {
  // From the ankle to the sole's corner next to the other foot, the foot turned towards it.
  const double inner = left.sole_size().y() / 2 - left.sole().y();
  const double front = left.sole_size().x() / 2 + std::abs(left.sole().x());
  return inner + std::max(0.0, inner * std::cos(turn) + front * std::sin(turn)) + kFootClearance_m;
}

class GaitChecker {
 public:
  GaitChecker(const Robot& robot, const mjModel* nominal, const GaitOptions& gait, const PathOptions& path,
              const PhysicsOptions& physics)
      : robot_(robot),
        nominal_(nominal),
        options_(ReadWalkerOptions(robot)),
        gait_(gait),
        period_s_(physics.control_period_ms * 1e-3),
        leg_(robot, 0) {
    const Path geometry(path, {});
    turns_ = geometry.TotalTurn() > 0;
    walks_ = !geometry.segments().empty();
  }

  void Check() const {
    CheckFields(gait_, "gait.");
    CheckTiming();
    if (walks_) CheckSpacing();
    if (!Reachable(gait_)) Blame();
  }

 private:
  void CheckTiming() const {
    const double shortest = kMinSwingTicks * period_s_ / (1 - gait_.double_support_ratio);
    if (gait_.period_s < shortest) {
      throw BadOption(fmt::format("gait.period_s: {} is below {}, {} control periods of {} s in the swing of a step",
                                  Number(gait_.period_s), Number(shortest), kMinSwingTicks, Number(period_s_)));
    }
    if (walks_ && gait_.step_length_m < 0.002) {
      throw BadOption(fmt::format("gait.step_length_m: {} is below 0.002, so the path would never end",
                                  Number(gait_.step_length_m)));
    }
  }

  void CheckSpacing() const {
    const double narrowest = NarrowestSpacing(leg_, turns_ ? options_.max_turn_rad : 0);
    if (gait_.foot_spacing_m >= narrowest) return;
    throw BadOption(fmt::format("gait.foot_spacing_m: {} is below {}, where {}'s feet touch{}",
                                Number(gait_.foot_spacing_m), Number(narrowest), robot_.name,
                                turns_ ? " while turning" : ""));
  }

  /// Plans a short walk, and a turn on the spot if the path has turns, and solves the inverse kinematics at every tick.
  bool Reachable(const GaitOptions& gait) const {
    if (gait.crouch_m >= leg_.reach()) return false;
    PathOptions walk;
    walk.kind = walks_ && gait.step_length_m > 0 ? PathKind::kStraight : PathKind::kStand;
    walk.length_m = std::max(0.05, 9 * gait.step_length_m);
    walk.settle_s = 0.2;
    if (!PlanIsReachable(gait, walk)) return false;
    if (!turns_) return true;
    walk.kind = PathKind::kPolyline;
    walk.points = {{0, 0.05}};  // a quarter turn to the left, then hardly a step
    GaitOptions turn = gait;
    turn.step_length_m = std::clamp(gait.step_length_m, 0.002, 0.02);
    return PlanIsReachable(turn, walk);
  }

  bool PlanIsReachable(const GaitOptions& gait, const PathOptions& walk) const {
    // Half the control rate is enough to see the extremes of a swing.
    GaitPlan plan = PlanGait(robot_, nominal_, options_, gait, walk, 2 * period_s_, {});
    const auto reachable = [](const Posture::Solution& s) { return s.legs[0].reachable && s.legs[1].reachable; };
    if (!reachable(plan.initial)) return false;
    while (!plan.pattern.Finished()) {
      if (!reachable(plan.posture.Solve(plan.pattern.Advance({}).posture, 2))) return false;
    }
    return true;
  }

  /// The feasible value nearest to `asked`, by bisection from a `harmless` one.
  double Limit(const std::function<GaitOptions(double)>& with, double harmless, double asked) const {
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (harmless + asked);
      (Reachable(with(middle)) ? harmless : asked) = middle;
    }
    return harmless;
  }

  [[noreturn]] void Blame() const {
    const auto with_step = [&](double v) {
      GaitOptions g = gait_;
      return g.step_length_m = v, g;
    };
    const auto on_the_spot = [&](double lift) {
      GaitOptions g = with_step(0.002);
      g.lift_m = lift;
      g.landing_offset_m = std::max(0.0, g.landing_offset_m);
      return g;
    };
    const std::string legs = "the reach of " + robot_.name + "'s legs at crouch " + Number(gait_.crouch_m) + " m";
    if (!Reachable(on_the_spot(0.001))) BlameStance();
    if (!Reachable(on_the_spot(gait_.lift_m))) {
      throw BadOption(fmt::format("gait.lift_m: {} exceeds {}, {}", Number(gait_.lift_m),
                                  Number(Limit(on_the_spot, 0.001, gait_.lift_m)), legs));
    }
    if (!Reachable(with_step(0.002))) {
      throw BadOption(fmt::format("gait.landing_offset_m: {} is beyond {}", Number(gait_.landing_offset_m), legs));
    }
    throw BadOption(fmt::format("gait.step_length_m: {} exceeds {}, {}", Number(gait_.step_length_m),
                                Number(Limit(with_step, 0.002, gait_.step_length_m)), legs));
  }

  /// Not even stepping on the spot is feasible: the hips are too high or too low, or the feet too far apart.
  [[noreturn]] void BlameStance() const {
    const auto with_crouch = [&](double v) {
      GaitOptions g = gait_;
      g.crouch_m = v, g.step_length_m = 0.002, g.lift_m = 0.001, g.landing_offset_m = 0;
      return g;
    };
    for (const double part : {0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4}) {
      const double fits = part * leg_.reach();
      if (!Reachable(with_crouch(fits))) continue;
      const bool too_high = gait_.crouch_m < fits;
      throw BadOption(fmt::format("gait.crouch_m: {} is {} {}, what {}'s legs can do at a foot spacing of {} m",
                                  Number(gait_.crouch_m), too_high ? "below" : "above",
                                  Number(Limit(with_crouch, fits, gait_.crouch_m)), robot_.name,
                                  Number(gait_.foot_spacing_m)));
    }
    throw BadOption(fmt::format("gait.foot_spacing_m: {} is out of reach of {}'s legs, whose hips are {} m apart",
                                Number(gait_.foot_spacing_m), robot_.name, Number(2 * std::abs(leg_.hip().y()))));
  }

  Robot robot_;
  const mjModel* nominal_;
  WalkerOptions options_;
  GaitOptions gait_;
  double period_s_;
  LegKinematics leg_;
  bool turns_ = false, walks_ = false;
};

}  // namespace

void CheckGait(const Robot& robot, const mjModel* nominal, const GaitOptions& gait, const PathOptions& path,
               const PhysicsOptions& physics) {
  GaitChecker(robot, nominal, gait, path, physics).Check();
}

}  // namespace gaitcam
