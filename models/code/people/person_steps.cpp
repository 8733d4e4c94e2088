#include "models/code/people/person_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Step length over cadence of people who walk as they like: 0.0065 m per (step/min), at any speed (Sekiya et al., "The
/// invariant relationship between step length and step rate during free walking", 1996).
constexpr double kWalkRatio = 0.0065 * 60;
constexpr double kShortestStep_s = 0.42, kLongestStep_s = 0.6;  // slower walkers make shorter steps instead
constexpr double kSlow = 0.3, kTurns = 1,
                 kSlowStep_s = 0.42;  // m/s and rad/s: slower, or turning faster, one makes quick steps
constexpr double kMoved_m = 0.09, kTurned = 15 * kRadPerDeg;  // what a standing person makes a step for
constexpr double kPauseMore_s = 0.1;                          // until it is asked again
constexpr double kAtEase_s = 0.4;                             // of a pause: the hips have come to rest
constexpr double kAfter = 0.875;   // of a step: middle of the double support, where the hips are midway
constexpr double kCrossed = 0.05;  // of the height: so far a foot may come over to the other one's side
constexpr double kLongest = 0.55;  // of the height: from one foot to the other

/// Where the course is at `time_s` from its begin.
Vector3d PoseAt(const PersonCourse& course, double time_s) {
  const double at = std::clamp(time_s / course.step_s, 0.0, double(course.poses.size() - 1));
  const size_t i = std::min(size_t(at), course.poses.size() - 1), next = std::min(i + 1, course.poses.size() - 1);
  return course.poses[i] + (at - double(i)) * (course.poses[next] - course.poses[i]);
}

/// Left is positive.
double LeftOf(const Vector2d& spot, double yaw, const Vector2d& p) {
  return -std::sin(yaw) * (p.x() - spot.x()) + std::cos(yaw) * (p.y() - spot.y());
}

class CourseWalker {
 public:
  CourseWalker(const PersonCourse& course, double height_m, std::vector<PersonStep> begun)
      : course_(course), height_(height_m), steps_(std::move(begun)) {
    feet_.fill({course.poses[0].head<2>(), course.poses[0].z()});
    for (const PersonStep& step : steps_) {
      time_ += step.duration_s;
      rests_ = step.side < 0 ? std::min(2, rests_ + 1) : 0;
      if (step.side < 0) continue;
      feet_[size_t(step.side)] = step.to;
      last_ = step.side;
    }
  }

  std::vector<PersonStep> Walk() {
    const double end = double(course_.poses.size() - 1) * course_.step_s;
    while (time_ < end) {
      const double duration = StepDuration();
      const int side = NextSide(duration);
      if (side < 0) {
        Rest();
      } else {
        Step(side, Landing(side, duration), duration);
      }
    }
    for (const int side : {1 - last_, last_}) {  // the last steps end with the course
      if (Wants(side, kShortestStep_s)) Step(side, Landing(side, kShortestStep_s), kShortestStep_s);
    }
    Rest();
    return std::move(steps_);
  }

 private:
  /// From the speed of the course over the next second.
  double StepDuration() const {
    constexpr double kAhead_s = 1;
    const Vector3d way = PoseAt(course_, time_ + kAhead_s) - PoseAt(course_, time_);
    const double speed = way.head<2>().norm() / kAhead_s;
    if (speed < kSlow || std::abs(way.z()) > kTurns) return kSlowStep_s;
    return std::clamp(StepLength(speed, height_) / speed, kShortestStep_s, kLongestStep_s);
  }

  /// Where the body is half a step after the hips are midway between this foot and the other one; in bends as far
  /// outside as the middle of two prints lies inside.
  Vector3d Wanted(double duration) const {
    const double middle = time_ + kAfter * duration - kHipsLead_s;
    const Vector3d next = PoseAt(course_, middle + duration / 2);
    const Vector3d inside = (PoseAt(course_, middle - duration / 2) + next) / 2 - PoseAt(course_, middle);
    return {next.x() - inside.x(), next.y() - inside.y(), next.z()};
  }

  bool Wants(int side, double duration) const {
    const Vector3d wanted = Wanted(duration);
    const FootSpot& foot = feet_[size_t(side)];
    return (wanted.head<2>() - foot.spot).norm() > kMoved_m || std::abs(wanted.z() - foot.yaw) > kTurned;
  }

  /// The other foot than the last one, unless it stands well already; from standing, the inner one of a turn. -1: none.
  int NextSide(double duration) const {
    if (rests_ > 0) {
      const double turn = Wanted(duration).z() - feet_[0].yaw;
      const double left = LeftOf(feet_[0].spot, feet_[0].yaw, Wanted(duration).head<2>());
      const int inner = std::abs(turn) > kTurned ? (turn > 0 ? 0 : 1) : left > 0 ? 0 : 1;
      return Wants(inner, duration) ? inner : Wants(1 - inner, duration) ? 1 - inner : -1;
    }
    return Wants(1 - last_, duration) ? 1 - last_ : Wants(last_, duration) ? last_ : -1;
  }

  FootSpot Landing(int side, double duration) const {
    const Vector3d wanted = Wanted(duration);
    const FootSpot& other = feet_[size_t(1 - side)];
    const double yaw = other.yaw + std::clamp(wanted.z() - other.yaw, -kMostTurnOfStep, kMostTurnOfStep);
    Vector2d spot = wanted.head<2>();
    const double sign = side == 0 ? 1 : -1, over = sign * LeftOf(other.spot, yaw, spot) + kCrossed * height_;
    if (over < 0) spot -= sign * over * Vector2d(-std::sin(yaw), std::cos(yaw));
    const Vector2d way = spot - other.spot;
    const double longest = kLongest * height_;
    if (way.norm() > longest) spot = other.spot + longest * way.normalized();
    return {spot, yaw};
  }

  void Step(int side, const FootSpot& to, double duration) {
    steps_.push_back({time_, duration, side, feet_[size_t(side)], to});
    feet_[size_t(side)] = to;
    last_ = side;
    time_ += duration;
    rests_ = 0;
  }

  /// Of two pauses: in the first one the hips come to rest, the second one is as long as it takes.
  void Rest() {
    const double pause = rests_ == 0 ? kAtEase_s : kPauseMore_s;
    if (rests_ == 2) {
      steps_.back().duration_s += pause;
    } else {
      steps_.push_back({time_, pause, -1, {}, {}});
      ++rests_;
    }
    time_ += pause;
  }

  const PersonCourse& course_;
  const double height_;
  double time_ = 0;
  std::array<FootSpot, 2> feet_;
  int last_ = 1;
  int rests_ = 1;  ///< Pauses since the last step, up to 2; it begins at rest.
  std::vector<PersonStep> steps_;
};

}  // namespace

double StepLength(double speed_m_s, double height_m) {
  return std::sqrt(kWalkRatio * speed_m_s) * height_m / kUsualHeight_m;
}

std::vector<PersonStep> StepsAlong(const PersonCourse& course, double height_m, std::vector<PersonStep> begun) {
  GAITCAM_ASSERT(!course.poses.empty());
  return CourseWalker(course, height_m, std::move(begun)).Walk();
}

std::vector<PersonStep> StepsBegun(std::vector<PersonStep> steps, double time_s) {
  std::erase_if(steps, [&](const PersonStep& step) { return step.begin_s >= time_s; });
  const size_t count = steps.size();
  const bool at_ease = count > 0 && steps.back().side < 0 && (count == 1 || steps[count - 2].side < 0);
  if (at_ease) {
    PersonStep& pause = steps.back();
    const double asked = std::ceil((time_s - pause.begin_s) / kPauseMore_s - 1e-6);
    pause.duration_s = std::min(pause.duration_s, std::max(1.0, asked) * kPauseMore_s);
  }
  return steps;
}

}  // namespace gaitcam
