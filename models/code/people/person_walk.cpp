#include "models/code/people/person_walk.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "models/code/people/person_steps.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPause = 0.45;               // s between a stretch and a turn
constexpr double kTurnStep = 0.45;            // s per step while turning on the spot
constexpr double kMaxBend = 60 * kRadPerDeg;  // largest bend of the path that is walked without stopping
constexpr double kHeelOff = 0.45;             // of a step: the heel rises this long before lift-off
constexpr double kLoading = 0.25;             // of a step: duration of rolling from heel to flat
constexpr double kReach = 0.995;              // of a stretched leg
constexpr double kToeOut = 6 * kRadPerDeg;

double Heading(const Vector2d& way) { return std::atan2(way.y(), way.x()); }

Vector2d Turned(double x, double y, double yaw) {
  return {x * std::cos(yaw) - y * std::sin(yaw), x * std::sin(yaw) + y * std::cos(yaw)};
}

/// A spot on a polyline and the direction there.
FootSpot AlongPath(const std::vector<Vector2d>& points, double way, double yaw_near) {
  size_t i = 0;
  while (i + 2 < points.size() && way > (points[i + 1] - points[i]).norm()) {
    way -= (points[i + 1] - points[i]).norm();
    ++i;
  }
  const Vector2d along = (points[i + 1] - points[i]).normalized();
  return {points[i] + way * along, yaw_near + WrapAngle(Heading(along) - yaw_near)};
}

double Length(const std::vector<Vector2d>& points) {
  double length = 0;
  for (size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

/// Parts of a path between bends above kMaxBend, where a person stops and turns.
std::vector<std::vector<Vector2d>> Stretches(const std::vector<Vector2d>& path) {
  std::vector<std::vector<Vector2d>> stretches{{path[0]}};
  for (size_t i = 1; i < path.size(); ++i) {
    stretches.back().push_back(path[i]);
    if (i + 1 == path.size()) break;
    const double bend = WrapAngle(Heading(path[i + 1] - path[i]) - Heading(path[i] - path[i - 1]));
    if (std::abs(bend) > kMaxBend) stretches.push_back({path[i]});
  }
  return stretches;
}

double SmoothMin(double a, double b) {
  constexpr double kSoft = 0.012;  // m
  const double least = std::min(a, b);
  return least - kSoft * std::log(std::exp((least - a) / kSoft) + std::exp((least - b) / kSoft));
}

}  // namespace

PersonWalk::PersonWalk(const PersonOptions& options) : options_(options), body_(options.height_m) {
  GAITCAM_ASSERT(!options.path.empty());
  double yaw = options.facing_deg * kRadPerDeg;
  if (options.path.size() > 1) yaw = Heading(options.path[1] - options.path[0]);
  first_.fill({options.path[0], yaw});
  last_ = first_;
  if (options.course) {
    FollowCourse({});
    return;
  }
  AddHips(0, true);
  if (options.speed_m_s == 0) return;
  GAITCAM_ASSERT(options.path.size() > 1);
  step_length_ = StepLength(options.speed_m_s, options.height_m);
  PlanSteps();
}

void PersonWalk::FollowFrom(double time_s, std::shared_ptr<const PersonCourse> course) {
  GAITCAM_ASSERT(options_.course && course->begin_s == options_.course->begin_s);
  GAITCAM_ASSERT(course->poses.front() == options_.course->poses.front());
  options_.course = std::move(course);
  std::vector<PersonStep> begun = StepsBegun(std::exchange(steps_, {}), time_s - start_s() + kPlanned_s);
  hips_.clear();
  duration_s_ = 0;
  FollowCourse(std::move(begun));
}

/// Of a crowd's simulation.
void PersonWalk::FollowCourse(std::vector<PersonStep> begun) {
  const PersonCourse& course = *options_.course;
  GAITCAM_ASSERT(!course.poses.empty());
  first_.fill({course.poses[0].head<2>(), course.poses[0].z()});
  last_ = first_;
  options_.repeat = false;
  AddHips(0, true);
  for (const PersonStep& step : StepsAlong(course, options_.height_m, std::move(begun))) {
    if (step.side < 0) {
      AddPause(step.duration_s);
    } else {
      AddStep(step.side, step.to, step.duration_s);
    }
  }
}

void PersonWalk::PlanSteps() {
  std::vector<Vector2d> path = options_.path;
  AddPause(PauseAfterStretch());
  for (int way = 0; way < (options_.repeat ? 2 : 1); ++way) {
    for (const std::vector<Vector2d>& stretch : Stretches(path)) {
      AddTurn(Heading(stretch[1] - stretch[0]));
      AddStretch(stretch);
    }
    std::reverse(path.begin(), path.end());
  }
  if (options_.repeat) AddTurn(first_[0].yaw);  // as it began
}

double PersonWalk::PauseAfterStretch() const { return std::max(kPause, 0.6 * step_length_ / options_.speed_m_s); }

void PersonWalk::AddPause(double duration_s) {
  steps_.push_back({duration_s_, duration_s, -1, {}, {}});
  duration_s_ += duration_s;
  AddHips(duration_s_, true);
}

void PersonWalk::AddStep(int side, const FootSpot& to, double duration_s) {
  steps_.push_back({duration_s_, duration_s, side, last_[side], to});
  last_[side] = to;
  AddHips(duration_s_ + (0.5 + 0.5 * kSwing) * duration_s, false);
  duration_s_ += duration_s;
}

/// A turn on the spot, foot by foot, the inner one first.
void PersonWalk::AddTurn(double yaw) {
  const FootSpot here = last_[0];
  const double turn = WrapAngle(yaw - here.yaw);
  const int count = int(std::ceil(std::abs(turn) / kMostTurnOfStep - 1e-9));
  if (count == 0 || std::abs(turn) < 1e-9) return;
  int side = turn > 0 ? 0 : 1;
  for (int i = 1; i <= count; ++i, side = 1 - side) AddStep(side, {here.spot, here.yaw + turn * i / count}, kTurnStep);
  AddStep(side, {here.spot, here.yaw + turn}, kTurnStep);
  AddPause(PauseAfterStretch());
}

/// Equal steps from standing to standing; the last brings the feet together.
void PersonWalk::AddStretch(const std::vector<Vector2d>& points) {
  const double length = Length(points);
  const int count = std::max(1, int(std::lround(length / step_length_)));
  const double duration = length / count / options_.speed_m_s;
  int side = 0;
  for (int i = 1; i <= count + 1; ++i, side = 1 - side) {
    AddStep(side, AlongPath(points, std::min(i, count) * length / count, last_[1 - side].yaw), duration);
  }
  AddPause(PauseAfterStretch());
}

/// The hips are midway between the feet at mid double support.
void PersonWalk::AddHips(double time_s, bool still) {
  const Vector2d spot = (last_[0].spot + last_[1].spot) / 2;
  HipsKnot knot{time_s, {spot.x(), spot.y(), (last_[0].yaw + last_[1].yaw) / 2}, Vector3d::Zero(), still};
  hips_.push_back(knot);
  if (hips_.size() < 3) return;
  HipsKnot& middle = hips_[hips_.size() - 2];
  const HipsKnot& before = hips_[hips_.size() - 3];
  if (!middle.still) middle.rate = (knot.pose - before.pose) / (knot.time_s - before.time_s);
}

/// Cubic Hermite interpolation.
PersonWalk::HipsKnot PersonWalk::HipsAt(double lap_s) const {
  const auto after = std::upper_bound(hips_.begin(), hips_.end(), lap_s,
                                      [](double time, const HipsKnot& knot) { return time < knot.time_s; });
  if (after == hips_.begin()) return hips_.front();
  if (after == hips_.end()) return hips_.back();
  const HipsKnot &a = *(after - 1), &b = *after;
  const double h = b.time_s - a.time_s, u = (lap_s - a.time_s) / h;
  const double u2 = u * u, u3 = u2 * u;
  HipsKnot now{lap_s, Vector3d::Zero(), Vector3d::Zero(), false};
  now.pose = (2 * u3 - 3 * u2 + 1) * a.pose + (u3 - 2 * u2 + u) * h * a.rate + (3 * u2 - 2 * u3) * b.pose +
             (u3 - u2) * h * b.rate;
  now.rate = (6 * u2 - 6 * u) / h * (a.pose - b.pose) + (3 * u2 - 4 * u + 1) * a.rate + (3 * u2 - 2 * u) * b.rate;
  return now;
}

double PersonWalk::LapTime(double time_s) const {
  const double walked = std::max(0.0, time_s - start_s());
  if (duration_s_ == 0) return 0;
  return options_.repeat ? std::fmod(walked, duration_s_) : std::min(walked, duration_s_);
}

/// The last step of a foot that has started, or null.
const PersonStep* PersonWalk::StepOf(int side, double lap_s) const {
  const auto later = FirstStepAfter(lap_s);
  const auto last = std::find_if(std::make_reverse_iterator(later), steps_.rend(),
                                 [side](const PersonStep& step) { return step.side == side; });
  return last == steps_.rend() ? nullptr : &*last;
}

std::vector<PersonStep>::const_iterator PersonWalk::FirstStepAfter(double lap_s) const {
  return std::upper_bound(steps_.begin(), steps_.end(), lap_s,
                          [](double time, const PersonStep& step) { return time < step.begin_s; });
}

const PersonStep* PersonWalk::NextStepOf(int side, double lap_s) const {
  const auto next =
      std::find_if(FirstStepAfter(lap_s), steps_.end(), [side](const PersonStep& step) { return step.side == side; });
  return next == steps_.end() ? nullptr : &*next;
}

bool PersonWalk::Stands(int side, double time_s) const {
  const double lap = LapTime(time_s);
  const PersonStep* step = StepOf(side, lap);
  return step == nullptr || lap >= step->begin_s + kSwing * step->duration_s;
}

/// Height of the heel at lift-off; it grows with the step length.
double PersonWalk::PushOff(const PersonStep& step) const {
  return 6 * kRadPerDeg +
         36 * kRadPerDeg * std::min(1.0, (step.to.spot - step.from.spot).norm() / (0.75 * body_.height));
}

/// Height of the toes at heel strike.
double PersonWalk::Landing(const PersonStep& step) const {
  return 18 * kRadPerDeg * std::min(1.0, (step.to.spot - step.from.spot).norm() / (0.75 * body_.height));
}

/// A stance foot, rolled over its ball (pitch > 0) or its heel (pitch < 0).
PersonFoot PersonWalk::Standing(int side, const FootSpot& print, double pitch) const {
  const double left = side == 0 ? 1 : -1;
  PersonFoot foot;
  foot.yaw = print.yaw + left * kToeOut;
  foot.pitch = pitch;
  foot.bend = std::max(0.0, pitch);
  foot.ball << print.spot + Turned(body_.foot_ahead, left * body_.foot_aside, print.yaw), 0;
  if (pitch < 0) {
    foot.ball.head<2>() -= Turned(body_.heel * (1 - std::cos(pitch)), 0, foot.yaw);
    foot.ball.z() = -body_.heel * std::sin(pitch);
  }
  return foot;
}

/// From toe-off to heel strike; the clearance of the foot's lowest point follows a curve of its own.
PersonFoot PersonWalk::Swinging(const PersonStep& step, double part) const {
  const double push_off = PushOff(step), landing = Landing(step), way = Ease(part);
  const PersonFoot from = Standing(step.side, step.from, push_off), to = Standing(step.side, step.to, -landing);
  PersonFoot foot;
  foot.ball = from.ball + way * (to.ball - from.ball);
  foot.yaw = from.yaw + way * (to.yaw - from.yaw);
  foot.pitch = push_off * (1 - Ease(part / 0.7)) - landing * Ease((part - 0.4) / 0.6);
  foot.bend = push_off * (1 - Ease(part / 0.35));
  const double lift = 0.02 * body_.height * 16 * part * part * (1 - part) * (1 - part);
  const double lowest =
      std::min({0.0, body_.heel * std::sin(foot.pitch), -body_.toes * std::sin(foot.pitch - foot.bend)});
  foot.ball.z() = lift - lowest;
  return foot;
}

PersonFoot PersonWalk::FootAt(int side, double lap_s) const {
  const PersonStep* step = StepOf(side, lap_s);
  double pitch = 0;
  if (step) {
    const double part = (lap_s - step->begin_s) / step->duration_s;
    if (part < kSwing) return Swinging(*step, part / kSwing);
    pitch = -Landing(*step) * (1 - Ease((part - kSwing) / kLoading));
  }
  if (const PersonStep* next = NextStepOf(side, lap_s)) {
    const double before = (next->begin_s - lap_s) / next->duration_s;
    pitch += PushOff(*next) * Ease(1 - before / kHeelOff);
  }
  return Standing(side, step ? step->to : first_[side], pitch);
}

/// As high as the legs reach, which makes the hips rise and fall twice in a cycle.
double PersonWalk::HipsHeight(const std::array<PersonFoot, 2>& feet, const Vector3d& hips) const {
  const double leg = kReach * (body_.thigh + body_.shank);
  double height[2];
  for (int side = 0; side < 2; ++side) {
    const Vector3d ankle = feet[side].Shoe() * Vector3d(-body_.ankle_back, 0, body_.ankle_height);
    const Vector2d hip = hips.head<2>() + Turned(0, (side == 0 ? 1 : -1) * body_.hip_half_width, hips.z());
    height[side] = ankle.z() + std::sqrt(std::max(0.04, leg * leg - (hip - ankle.head<2>()).squaredNorm()));
  }
  return SmoothMin(height[0], height[1]);
}

PersonStance PersonWalk::Upright(double lap_s) const {
  PersonStance stance;
  stance.feet = {FootAt(0, lap_s), FootAt(1, lap_s)};
  const HipsKnot knot = HipsAt(lap_s);
  stance.yaw = knot.pose.z();
  stance.speed = knot.rate.head<2>().norm();
  // The hips lead the feet slightly while walking, and rotate with the leading leg.
  const Vector2d forward = Turned(1, 0, stance.yaw);
  stance.right_ahead = forward.dot((stance.feet[1].ball - stance.feet[0].ball).head<2>());
  const Vector2d spot = knot.pose.head<2>() + kHipsLead_s * stance.speed * forward;
  stance.hips_yaw = stance.yaw + 0.22 * stance.right_ahead / body_.height * kUsualHeight_m;
  const double height = HipsHeight(stance.feet, {spot.x(), spot.y(), stance.hips_yaw});
  stance.hips = Pose(RotZ(stance.hips_yaw), {spot.x(), spot.y(), height});
  return stance;
}

/// Upright on a seat, the feet flat before it.
PersonStance PersonWalk::Sitting() const {
  const double thick = 0.05 * body_.height;  // from the joint of a hip down to what one sits on
  PersonStance stance;
  const FootSpot& seat = first_[0];
  stance.yaw = stance.hips_yaw = seat.yaw;
  for (int side = 0; side < 2; ++side) {
    PersonFoot& foot = stance.feet[size_t(side)];
    const double left = side == 0 ? 1 : -1;
    foot.yaw = seat.yaw + left * kToeOut;
    foot.ball << seat.spot + Turned(0.85 * body_.thigh + body_.ankle_back, 1.6 * left * body_.foot_aside, seat.yaw), 0;
  }
  stance.hips = Pose(RotZ(seat.yaw), {seat.spot.x(), seat.spot.y(), options_.manner.seat_m + thick});
  return stance;
}

PersonPose PersonWalk::At(double time_s) const {
  const PersonStance stance = options_.manner.seat_m > 0 ? Sitting() : Upright(LapTime(time_s));
  return PoseParts(body_, stance, options_.manner, time_s);
}

}  // namespace gaitcam
