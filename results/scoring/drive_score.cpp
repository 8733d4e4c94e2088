#include "results/scoring/drive_score.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "algorithms/core/units.h"
#include "results/scoring/metrics.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kMoving_mps = 0.02;           // a base that turns on the spot or settles is not going anywhere
constexpr int64_t kSample_ns = 50'000'000;     // people walk 7 cm in it
constexpr int64_t kPause_ns = 30'000'000'000;  // views farther apart in time are of different passes

Vector2d Floor(const Pose& X_WC, const Pose& X_BC) { return (X_WC * X_BC.Inverse()).translation.head<2>(); }

double DistanceTo(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d way = b - a;
  const double length2 = way.squaredNorm();
  const double part = length2 > 0 ? std::clamp((p - a).dot(way) / length2, 0.0, 1.0) : 0;
  return (a + part * way - p).norm();
}

double DistanceTo(const Vector2d& p, const std::vector<Vector2d>& way) {
  if (way.empty()) return kNaN;
  double least = (way.front() - p).norm();
  for (size_t i = 0; i + 1 < way.size(); ++i) least = std::min(least, DistanceTo(p, way[i], way[i + 1]));
  return least;
}

/// Where the body truly was from the first to the last view of a route, when it was taught; straight where the route
/// changes from one pass to another.
std::vector<Vector2d> TaughtWay(const DriveRoute& route, const Trajectory& taught, const Pose& X_BC) {
  std::vector<Vector2d> way;
  const auto add = [&](int64_t stamp_ns) {
    if (const auto pose = PoseAt(taught, stamp_ns)) way.push_back(Floor(*pose, X_BC));
  };
  for (size_t i = 0; i < route.views_ns.size(); ++i) {
    const int64_t to = route.views_ns[i], from = i == 0 ? to : route.views_ns[i - 1];
    const bool one_pass = to > from && to - from < kPause_ns;
    for (auto pose = std::upper_bound(taught.begin(), taught.end(), from,
                                      [](int64_t stamp, const StampedPose&p) { return stamp < p.stamp_ns; });
         one_pass && pose != taught.end() && pose->stamp_ns < to; ++pose) {
      way.push_back(Floor(pose->pose, X_BC));
    }
    add(to);
  }
  return way;
}

/// The route that it was on, or -1.
int RouteAt(const TaughtDrive& drive, int step) {
  int route = -1;
  while (route + 1 < int(drive.routes.size()) && drive.routes[size_t(route + 1)].from_step <= step) ++route;
  return route;
}

double ClearanceOf(const Vector2d& robot, const Vector2d& person, const DriveScoreOptions& options) {
  return (person - robot).norm() - options.body_radius_m - options.person_radius_m;
}

double NearestPerson(const Vector2d& robot, const std::vector<Vector2d>& people, const DriveScoreOptions& options) {
  double least = kNaN;
  for (const Vector2d& person : people) least = std::fmin(least, ClearanceOf(robot, person, options));
  return least;
}

std::vector<DrivenStep> DrivenSteps(const TaughtDrive& drive, const DriveTruth& truth, const DriveScoreOptions& options,
                                    const std::vector<std::vector<Vector2d>>& taught_m) {
  std::vector<DrivenStep> steps;
  for (int s = 0; s < int(drive.steps.size()); ++s) {
    const int64_t stamp_ns = drive.steps[size_t(s)].stamp_ns;
    const std::optional<Pose> pose = PoseAt(truth.driven, stamp_ns);
    DrivenStep step;
    const int route = RouteAt(drive, s);
    if (pose) {
      const PlanarPose X_WB(*pose * drive.X_BC.Inverse());
      step.at_m = X_WB.position;
      step.heading_rad = X_WB.heading;
      step.people_m = truth.people(stamp_ns);
      step.person_m = NearestPerson(step.at_m, step.people_m, options);
    }
    const DriveStep& said = drive.steps[size_t(s)];
    if (pose && !truth.taught.empty() && (said.confirmed || said.state != DriveState::kSearching)) {
      const PlanarPose X_WF(truth.taught.front().pose * drive.X_BC.Inverse());
      step.error_m = ((X_WF * said.X_FB).position - step.at_m).norm();
    }
    const int64_t before_ns = s > 0 ? drive.steps[size_t(s) - 1].stamp_ns : stamp_ns;
    step.carried = truth.carried && truth.carried->from_ns < stamp_ns && truth.carried->until_ns > before_ns;
    if (pose && route >= 0) step.beside_m = DistanceTo(step.at_m, taught_m[size_t(route)]);
    if (s > 0) {
      step.moved_m = (step.at_m - steps.back().at_m).norm();
      step.elapsed_s = 1e-9 * double(stamp_ns - before_ns);
    }
    steps.push_back(step);
  }
  return steps;
}

/// By itself.
bool Moved(const DrivenStep& step) { return !step.carried && step.moved_m > kMoving_mps * step.elapsed_s; }

class NearPeople {
 public:
  NearPeople(const DriveScoreOptions& options, DriveComparison& comparison)
      : options_(options), comparison_(comparison) {
    for (Approach* nearest :
         {&comparison.nearest, &comparison.while_towards, &comparison.by_own_motion, &comparison.in_view})
      nearest->clearance_m = std::numeric_limits<double>::infinity();
  }

  /// @param motion of the robot since the instant before. @param sees whether somebody there is in its camera's view.
  void Look(int64_t stamp_ns, const Vector2d& robot, const Vector2d& motion, const std::vector<Vector2d>& people,
            const std::function<bool(const Vector2d&)>& sees) {
    touched_.resize(people.size(), false);
    const bool moves = motion.norm() > kMoving_mps * 1e-9 * double(kSample_ns);
    for (size_t i = 0; i < people.size(); ++i) {
      const double clearance_m = ClearanceOf(robot, people[i], options_);
      Note(clearance_m, stamp_ns, comparison_.nearest);
      const Vector2d way = (people[i] - robot).normalized();
      const double approach_m = motion.dot(way);
      const double theirs_m = i < before_.size() ? (before_[i] - people[i]).dot(way) : 0;
      const bool towards = moves && approach_m > 0;
      if (towards) Note(clearance_m, stamp_ns, comparison_.while_towards);
      const bool its_own = towards && approach_m > theirs_m;
      if (its_own) Note(clearance_m, stamp_ns, comparison_.by_own_motion);
      if (its_own && sees(people[i])) Note(clearance_m, stamp_ns, comparison_.in_view);
      if (towards && clearance_m < 0 && !touched_[i]) {
        ++comparison_.touches;
        if (sees(people[i])) ++comparison_.touches_in_view;
      }
      touched_[i] = clearance_m < 0 && (touched_[i] || towards);
    }
    before_ = people;
  }

 private:
  static void Note(double clearance_m, int64_t stamp_ns, Approach& nearest) {
    if (clearance_m < nearest.clearance_m) nearest = {clearance_m, stamp_ns};
  }

  const DriveScoreOptions& options_;
  DriveComparison& comparison_;
  std::vector<char> touched_;
  std::vector<Vector2d> before_;
};

void FollowPeople(const TaughtDrive& drive, const DriveTruth& truth, const DriveScoreOptions& options,
                  DriveComparison& comparison) {
  NearPeople near(options, comparison);
  std::optional<Vector2d> before;
  const int64_t end_ns = drive.steps.empty() ? -1 : drive.steps.back().stamp_ns;
  for (int64_t t = drive.steps.empty() ? 0 : drive.steps.front().stamp_ns; t <= end_ns; t += kSample_ns) {
    const std::optional<Pose> pose = PoseAt(truth.driven, t);
    if (!pose) continue;
    const Vector2d robot = Floor(*pose, drive.X_BC);
    const std::vector<Vector2d> people = truth.people(t);
    const bool carried = truth.carried && truth.carried->from_ns < t && truth.carried->until_ns > t - kSample_ns;
    near.Look(
        t, robot, before && !carried ? Vector2d(robot - *before) : Vector2d(0, 0), people, [&](const Vector2d& person) {
          const Eigen::Vector3d p_C = pose->Inverse() * Eigen::Vector3d(person.x(), person.y(), pose->translation.z());
          return p_C.z() > 0 && std::abs(std::atan2(p_C.x(), p_C.z())) < drive.half_view_rad;
        });
    comparison.people_m.resize(people.size());
    for (size_t i = 0; i < people.size(); ++i) comparison.people_m[i].push_back(people[i]);
    before = robot;
  }
}

std::vector<double> Deviations(const DriveEvidence& e) {
  std::vector<double> beside;
  for (const DrivenStep& step : e.comparison.steps) {
    if (Moved(step) && std::isfinite(step.beside_m)) beside.push_back(step.beside_m);
  }
  return beside;
}

/// From where it has driven a metre on.
double DeviationOnTheWay(const DriveEvidence& e) {
  constexpr double kDrivenIn_m = 1;
  double way_m = 0, largest = kNaN;
  for (const DrivenStep& step : e.comparison.steps) {
    if (!Moved(step)) continue;
    way_m += step.moved_m;
    if (way_m > kDrivenIn_m) largest = std::fmax(largest, step.beside_m);
  }
  return largest;
}

double GoalError(const DriveEvidence& e) {
  if (e.comparison.taught_m.empty() || e.comparison.taught_m.back().empty() || e.comparison.steps.empty()) return kNaN;
  return (e.comparison.steps.back().at_m - e.comparison.taught_m.back().back()).norm();
}

bool SaysArrived(const TaughtDrive& drive) {
  return !drive.steps.empty() && drive.steps.back().state == DriveState::kArrived;
}

double TimeIn(const DriveEvidence& e, DriveState state) {
  double time_s = 0;
  for (size_t s = 1; s < e.drive.steps.size(); ++s) {
    if (e.drive.steps[s - 1].state == state) time_s += e.comparison.steps[s].elapsed_s;
  }
  return time_s;
}

/// By a view of the map, which shows somewhere else.
double TimeMisplaced(const DriveEvidence& e) {
  double time_s = 0;
  for (size_t s = 1; s < e.drive.steps.size(); ++s) {
    const bool misplaced = e.comparison.steps[s - 1].error_m > e.options.found_m;
    if (misplaced && e.drive.steps[s - 1].confirmed) time_s += e.comparison.steps[s].elapsed_s;
  }
  return time_s;
}

double MeanSpeed(const DriveEvidence& e) {
  double way_m = 0, time_s = 0;
  for (size_t s = 1; s < e.drive.steps.size(); ++s) {
    if (e.drive.steps[s - 1].state != DriveState::kDriving || e.comparison.steps[s].carried) continue;
    way_m += e.comparison.steps[s].moved_m;
    time_s += e.comparison.steps[s].elapsed_s;
  }
  return time_s > 0 ? way_m / time_s : kNaN;
}

double PartConfirmed(const TaughtDrive& drive) {
  const auto count = std::count_if(drive.steps.begin(), drive.steps.end(), [](const auto& s) { return s.confirmed; });
  return drive.steps.empty() ? kNaN : double(count) / double(drive.steps.size());
}

double TimeOf(const TaughtDrive& drive) {
  return drive.steps.empty() ? kNaN : 1e-9 * double(drive.steps.back().stamp_ns - drive.steps.front().stamp_ns);
}

/// NaN if it was never carried off, or never found itself again.
double TimeToFindItselfAgain(const DriveEvidence& e) {
  const auto& carried = e.comparison.carried;
  for (size_t s = 0; carried && s < e.drive.steps.size(); ++s) {
    const DriveStep& step = e.drive.steps[s];
    if (step.stamp_ns < carried->until_ns || !step.confirmed || !(e.comparison.steps[s].error_m < e.options.found_m))
      continue;
    return 1e-9 * double(step.stamp_ns - carried->until_ns);
  }
  return kNaN;
}

/// By itself, before it knew again where it was.
double WayWhileMistaken(const DriveEvidence& e) {
  const auto& carried = e.comparison.carried;
  if (!carried) return kNaN;
  const double found_s = TimeToFindItselfAgain(e);
  double way_m = 0;
  for (size_t s = 0; s < e.drive.steps.size(); ++s) {
    const double since_s = 1e-9 * double(e.drive.steps[s].stamp_ns - carried->until_ns);
    if (since_s <= 0 || since_s > found_s) continue;
    if (Moved(e.comparison.steps[s])) way_m += e.comparison.steps[s].moved_m;
  }
  return way_m;
}

/// NaN if there was nobody.
double Clearance(const Approach& approach) { return std::isfinite(approach.clearance_m) ? approach.clearance_m : kNaN; }

}  // namespace

DriveComparison CompareDrive(const TaughtDrive& drive, const DriveTruth& truth, const DriveScoreOptions& options) {
  CheckFields(options, "drive.");
  DriveComparison comparison;
  for (const DriveRoute& route : drive.routes) {
    comparison.taught_m.push_back(TaughtWay(route, truth.taught, drive.X_BC));
  }
  comparison.steps = DrivenSteps(drive, truth, options, comparison.taught_m);
  comparison.carried = truth.carried;
  FollowPeople(drive, truth, options, comparison);
  comparison.scores = Evaluate(DriveMetrics(), {drive, comparison, options});
  return comparison;
}

std::vector<Metric<DriveEvidence>> DriveMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kDrive;
  using E = DriveEvidence;
  return {
      {"drive_goal_reached", "", Better::kHigher, kGroup,
       "1 if the robot says that it has arrived and truly stands within 0.2 m of where the taught way has its goal",
       [](const E& e) { return SaysArrived(e.drive) && GoalError(e) <= e.options.goal_m ? 1.0 : 0.0; }, true},
      {"drive_goal_error_m", "m", Better::kLower, kGroup, "from where it stood at the end to where the taught way ends",
       [](const E& e) { return GoalError(e); }},
      {"drive_deviation_mean_m", "m", Better::kLower, kGroup,
       "true distance from the taught way, mean over all frames in which the robot moved",
       [](const E& e) { return Summarize(Deviations(e)).mean; }, true},
      {"drive_deviation_max_m", "m", Better::kLower, kGroup,
       "largest true distance from the taught way, that of a start beside it as well",
       [](const E& e) { return Summarize(Deviations(e)).max; }, true},
      {"drive_deviation_way_max_m", "m", Better::kLower, kGroup,
       "largest true distance from the taught way after the first metre driven",
       [](const E& e) { return DeviationOnTheWay(e); }},
      {"drive_speed_mps", "m/s", Better::kHigher, kGroup, "mean speed while nothing was in its way",
       [](const E& e) { return MeanSpeed(e); }},
      {"drive_time_s", "s", Better::kLower, kGroup, "from the first frame to the last one",
       [](const E& e) { return TimeOf(e.drive); }},
      {"drive_waited_s", "s", Better::kNeither, kGroup, "time in which it stood or slowed down for what was in its way",
       [](const E& e) { return TimeIn(e, DriveState::kWaiting); }},
      {"drive_searched_s", "s", Better::kLower, kGroup, "time in which it did not know where it was",
       [](const E& e) { return TimeIn(e, DriveState::kSearching); }},
      {"drive_misplaced_s", "s", Better::kLower, kGroup,
       "time in which it was sure of a place more than 0.2 m from where it was",
       [](const E& e) { return TimeMisplaced(e); }},
      {"drive_confirmed_ratio", "", Better::kHigher, kGroup,
       "part of the frames in which a view of the map said where it was, and no other place fitted",
       [](const E& e) { return PartConfirmed(e.drive); }},
      {"drive_refound_s", "s", Better::kLower, kGroup,
       "from when it was set down by who had carried it off until a view of the map told it where it truly was, to 0.2 "
       "m",
       [](const E& e) { return TimeToFindItselfAgain(e); }},
      {"drive_mistaken_m", "m", Better::kLower, kGroup,
       "way that it drove after it was set down and before it knew where it was",
       [](const E& e) { return WayWhileMistaken(e); }},
      {"drive_routes", "", Better::kNeither, kGroup, "ways that it planned",
       [](const E& e) { return double(e.drive.routes.size()); }},
      {"drive_clearance_m", "m", Better::kHigher, kGroup,
       "nearest that it came to a person by its own motion: it towards them, faster than they towards it; between "
       "surfaces (circles of 0.22 and 0.25 m)",
       [](const E& e) { return Clearance(e.comparison.by_own_motion); }, true},
      {"drive_clearance_in_view_m", "m", Better::kHigher, kGroup,
       "nearest that it came by its own motion to a person in its camera's field of view",
       [](const E& e) { return Clearance(e.comparison.in_view); }},
      {"drive_clearance_moving_m", "m", Better::kHigher, kGroup,
       "nearest that a person was while it moved towards them, whoever was faster",
       [](const E& e) { return Clearance(e.comparison.while_towards); }},
      {"drive_nearest_person_m", "m", Better::kHigher, kGroup, "nearest that a person was, whoever moved",
       [](const E& e) { return Clearance(e.comparison.nearest); }},
      {"drive_touches", "", Better::kLower, kGroup,
       "people that it touched while it moved towards them, whoever was faster",
       [](const E& e) { return double(e.comparison.touches); }, true},
      {"drive_touches_in_view", "", Better::kLower, kGroup, "of these, people in its camera's field of view",
       [](const E& e) { return double(e.comparison.touches_in_view); }}};
}

}  // namespace gaitcam
