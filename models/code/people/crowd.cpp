#include "models/code/people/crowd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/pose.h"
#include "models/code/people/crowd_forces.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kTick_s = 0.05;
constexpr int kTicksPerPose = 2, kTicksPerLook = 4;     // from one pose of a course, one look ahead, to the next
constexpr int kFirstTick = -200, kFirstRecorded = -40;  // before the run: until then people scatter
constexpr double kScatter_s = kFirstTick * kTick_s, kRecorded_s = kFirstRecorded * kTick_s;
constexpr double kAfterRun_s = 1;
constexpr int kForeseen = 40;          // ticks, by live walkers: steps to be planned depend on less
constexpr double kSeen_m = 5;          // whom walkers avoid
constexpr double kBodyRadius_m = 0.2;  // from which the distance to walls counts
constexpr double kFastest = 1.3;       // of the preferred speed (Helbing and Molnar, 1995)
constexpr double kArrived_m = 0.2, kArrivedTaken_m = 1.0;
constexpr double kSlowing_m = 0.7;                // before a goal
constexpr double kStuck_s = 4, kStuck_m = 0.5;    // less on the way in that time: another goal is easier
constexpr double kTurnGain = 4, kTurnRate = 2.4;  // 1/s, rad/s
constexpr double kHeadingSpeed = 0.25;            // m/s: from which the body turns where it walks
constexpr int kSettlings = 4;

struct Walker {
  size_t member;
  Passer at;
  double yaw, speed;
  RandomStream random;
  int goal = -1;
  bool stays = false;
  double until_s = 0;      ///< Of a stay.
  Vector2d ahead{0, 0};    ///< Where it walks straight to.
  double noticed_s = 0;    ///< When it was last asked whether it gets on ...
  Vector2d noticed{0, 0};  ///< ... and where it was then.
};

class CrowdSimulation {
 public:
  using Courses = std::vector<std::shared_ptr<PersonCourse>>;

  CrowdSimulation(const CrowdPlan& plan, const CrowdRoom& room)
      : crowd_(plan.crowd), robot_(plan.robot), map_(room.min, room.max, room.obstacles) {
    const uint64_t seed = crowd_.seed.value_or(plan.seed);
    cast_ = CastCrowd(crowd_, room, robot_, plan.duration_s, seed, map_);
    for (size_t i = 0; i < cast_.members.size(); ++i) {
      const CastMember& member = cast_.members[i];
      RandomStream random(seed, fmt::format("crowd.person{}", i));
      people_.push_back(DrawCrowdPerson(crowd_, random));
      people_.back().manner = MannerOf(member, random);
      courses_.push_back(std::make_shared<PersonCourse>());
      courses_.back()->begin_s = kRecorded_s;
      courses_.back()->step_s = kTicksPerPose * kTick_s;
      if (member.role == CrowdRole::kWalks || member.leave_s > 0) {
        walkers_.push_back({i, {member.at, {0, 0}}, member.yaw, people_.back().speed_m_s, random});
        Walker& walker = walkers_.back();
        walker.stays = member.leave_s > 0;
        walker.until_s = member.leave_s;
        walker.noticed_s = std::max(kScatter_s, walker.until_s);
        walker.noticed = member.at;
      } else {
        standing_.push_back({member.at, {0, 0}});
        courses_.back()->poses.emplace_back(member.at.x(), member.at.y(), member.yaw);
      }
    }
    held_.assign(cast_.goals.size(), 0);
  }

  static PersonManner MannerOf(const CastMember& member, RandomStream& random) {
    PersonManner manner;
    manner.seat_m = member.seat_m;
    manner.talks = member.role == CrowdRole::kTalks ? 1 : member.role == CrowdRole::kSits ? 0.4 : 0;
    manner.looks = member.role == CrowdRole::kTalks ? 0.3 : 0.5;
    manner.phase_s = random.Uniform(0, 100);
    return manner;
  }

  /// The state is then the one at time tick * kTick_s.
  void StepTo(int tick) {
    if (walkers_.empty()) return;
    for (; tick_ < tick; ++tick_) {
      if (tick_ >= kFirstRecorded && (tick_ - kFirstRecorded) % kTicksPerPose == 0) Record();
      Advance(tick_ * kTick_s, (tick_ - kFirstTick) % kTicksPerLook == 0);
    }
  }

  /// The courses so far, and how they would go on for kForeseen ticks.
  Courses Foresee() {
    const std::vector<Walker> walkers = walkers_;
    const std::vector<int> held = held_;
    const int tick = tick_;
    const Courses courses = courses_;
    for (const Walker& walker : walkers_) {
      std::shared_ptr<PersonCourse>& course = courses_[walker.member];
      course = std::make_shared<PersonCourse>(*course);
    }
    foresees_ = true;
    StepTo(tick + kForeseen);
    foresees_ = false;
    walkers_ = walkers;
    held_ = held;
    tick_ = tick;
    return std::exchange(courses_, courses);
  }

  /// From now on it is where this says.
  void SetRobot(RobotCourse robot) { robot_ = std::move(robot); }

  /// Of all members; one who never moves has a course of one pose.
  const Courses& courses() const { return courses_; }

  std::vector<PersonOptions> People() const {
    std::vector<PersonOptions> people = people_;
    for (size_t i = 0; i < people.size(); ++i) {
      people[i].name = fmt::format("crowd{}", i);
      people[i].path = {courses_[i]->poses[0].head<2>()};
      people[i].course = courses_[i];
    }
    return people;
  }

 private:
  void Record() {
    for (const Walker& walker : walkers_) {
      courses_[walker.member]->poses.emplace_back(walker.at.position.x(), walker.at.position.y(), walker.yaw);
    }
  }

  void Advance(double time_s, bool looks) {
    robot_now_.reset();
    if (robot_) {
      const Vector2d now = robot_(std::max(0.0, time_s)), next = robot_(std::max(0.0, time_s + kTick_s));
      robot_now_ = Passer{now, (next - now) / kTick_s};
      if (!foresees_) robot_from_ = now;
    }
    for (Walker& walker : walkers_) Decide(time_s, looks, walker);
    std::vector<Vector2d> accelerations;
    for (const Walker& walker : walkers_) accelerations.push_back(Acceleration(walker));
    std::vector<Vector2d> before;
    for (size_t i = 0; i < walkers_.size(); ++i) {
      Passer& at = walkers_[i].at;
      before.push_back(at.position);
      at.velocity = Slowed(at.velocity + kTick_s * accelerations[i], walkers_[i]);
      at.position += kTick_s * at.velocity;
    }
    Settle();
    for (size_t i = 0; i < walkers_.size(); ++i) {
      Walker& walker = walkers_[i];
      walker.at.velocity = Slowed((walker.at.position - before[i]) / kTick_s, walker);
      Turn(walker);
    }
  }

  static Vector2d Slowed(const Vector2d& velocity, const Walker& walker) {
    const double most = kFastest * walker.speed;
    return velocity.norm() > most ? Vector2d(most * velocity.normalized()) : velocity;
  }

  /// Goes on, stays, or gives a goal up.
  void Decide(double time_s, bool looks, Walker& walker) {
    if (walker.stays && time_s >= walker.until_s) {
      walker.stays = false;
      ChooseGoal(walker);
      looks = true;
    } else if (walker.goal < 0) {
      ChooseGoal(walker);
      looks = true;
    }
    if (walker.stays) return;
    if (time_s - walker.noticed_s >= kStuck_s) {
      if ((walker.at.position - walker.noticed).norm() < kStuck_m) {
        ChooseGoal(walker);
        looks = true;
      }
      walker.noticed_s = time_s;
      walker.noticed = walker.at.position;
    }
    const CrowdGoal& goal = cast_.goals[size_t(walker.goal)];
    const double arrived_m = held_[size_t(walker.goal)] > 1 ? kArrivedTaken_m : kArrived_m;
    if ((goal.spot.at - walker.at.position).norm() < arrived_m) {
      walker.stays = true;
      walker.until_s = time_s + (goal.stays ? walker.random.Uniform(crowd_.stay_s.x(), crowd_.stay_s.y()) : 0);
      walker.noticed_s = walker.until_s;
      walker.noticed = walker.at.position;
    } else if (looks) {
      walker.ahead = map_.Ahead(WaysOf(walker.goal), walker.at.position, goal.spot.at,
                                [&](const Vector2d& to) { return PassesBy(walker, to); });
    }
  }

  /// Whether a straight line leads past the robot and those who stay at a goal.
  bool PassesBy(const Walker& walker, const Vector2d& to) const {
    const auto clears = [&](const Vector2d& center, double radius) {
      const Vector2d along = to - walker.at.position, aside = center - walker.at.position;
      if (aside.norm() < radius + 0.1 || along.norm() < 1e-6) return true;
      const double part = std::clamp(aside.dot(along) / along.squaredNorm(), 0.0, 1.0);
      return (part * along - aside).norm() >= radius;
    };
    if (robot_now_ && !clears(robot_now_->position, crowd_.keep_off_m)) return false;
    return std::all_of(walkers_.begin(), walkers_.end(), [&](const Walker& other) {
      return !other.stays || &other == &walker || clears(other.at.position, kCrowdApart_m);
    });
  }

  /// Draws one that nobody goes to, rather far away, if there is such a one.
  void ChooseGoal(Walker& walker) {
    constexpr int kDraws = 40, kAnyLength = 20, kTaken = 30;  // what is given up after so many
    constexpr double kFar_m = 3;
    if (walker.goal >= 0) --held_[size_t(walker.goal)];
    const int before = walker.goal;
    for (int draw = 0; draw < kDraws; ++draw) {
      walker.goal = walker.random.Index(int(cast_.goals.size()));
      const bool far = (cast_.goals[size_t(walker.goal)].spot.at - walker.at.position).norm() > kFar_m;
      if (walker.goal != before && (far || draw > kAnyLength) && (held_[size_t(walker.goal)] == 0 || draw > kTaken)) {
        break;
      }
    }
    ++held_[size_t(walker.goal)];
  }

  const FloorMap::Ways& WaysOf(int goal) {
    const auto there = ways_.find(goal);
    if (there != ways_.end()) return there->second;
    return ways_.emplace(goal, map_.WaysTo(cast_.goals[size_t(goal)].spot.at)).first->second;
  }

  Vector2d Wanted(const Walker& walker) const {
    if (walker.stays) return {0, 0};
    const Vector2d way = walker.ahead - walker.at.position;
    if (way.norm() < 1e-6) return {0, 0};
    // Nobody walks off sideways: the body turns first.
    const double ahead = Vector2d(std::cos(walker.yaw), std::sin(walker.yaw)).dot(way.normalized());
    const double left = (cast_.goals[size_t(walker.goal)].spot.at - walker.at.position).norm();
    const double pace = std::clamp(1.5 * ahead - 0.3, 0.03, 1.0) * std::clamp(left / kSlowing_m, 0.25, 1.0);
    return pace * walker.speed * way.normalized();
  }

  Vector2d Acceleration(const Walker& walker) const {
    Vector2d sum = DrivingForce(Wanted(walker), walker.at.velocity);
    if (walker.stays) return sum;
    const auto avoid = [&](const Passer& other, double nearer_m) {
      const Vector2d away = walker.at.position - other.position;
      if (away.norm() > kSeen_m) return;
      sum += AvoidingForce(walker.at, other, nearer_m) + TouchForce(away.norm() - nearer_m, away.normalized());
    };
    for (const Walker& other : walkers_) {
      if (&other != &walker) avoid(other.at, 0);
    }
    for (const Passer& other : standing_) avoid(other, 0);
    if (robot_now_) avoid(*robot_now_, std::max(0.0, crowd_.keep_off_m - kCrowdApart_m));
    return sum + WallForce(map_.Clearance(walker.at.position) - kBodyRadius_m, map_.Away(walker.at.position));
  }

  /// Sets back who came too near: half a pair's overlap each, all of it before walls, furniture and the robot.
  void Settle() {
    for (int round = 0; round < kSettlings; ++round) {
      for (size_t i = 0; i < walkers_.size(); ++i) {
        for (size_t j = i + 1; j < walkers_.size(); ++j) {
          Vector2d &a = walkers_[i].at.position, &b = walkers_[j].at.position;
          const Vector2d push = Overlap(b - a, kCrowdApart_m) / 2;
          a -= push;
          b += push;
        }
      }
      for (Walker& walker : walkers_) {
        Vector2d& p = walker.at.position;
        if (robot_now_) p += Overlap(p - RobotNear(p), crowd_.keep_off_m);
        const double clearance = map_.Clearance(p);
        if (clearance < kCrowdFromWalls_m) p += (kCrowdFromWalls_m - clearance) * map_.Away(p);
      }
    }
  }

  /// Where it is; foreseen, the nearest point of where it may come to stand by then.
  Vector2d RobotNear(const Vector2d& p) const {
    const Vector2d way = robot_now_->position - robot_from_;
    if (way.norm() < 1e-9) return robot_now_->position;
    return robot_from_ + std::clamp((p - robot_from_).dot(way) / way.squaredNorm(), 0.0, 1.0) * way;
  }

  /// By how much what is `between` apart is to be moved on for a distance of `apart_m`.
  static Vector2d Overlap(const Vector2d& between, double apart_m) {
    const double distance = between.norm();
    if (distance >= apart_m || distance < 1e-9) return {0, 0};
    return (apart_m - distance) / distance * between;
  }

  void Turn(Walker& walker) const {
    double wanted = walker.yaw;
    if (walker.goal < 0) return;  // has not left yet
    if (walker.stays && walker.at.velocity.norm() < kHeadingSpeed) {
      wanted = cast_.goals[size_t(walker.goal)].spot.yaw;
    } else {
      const Vector2d way =
          walker.at.velocity.norm() > kHeadingSpeed ? walker.at.velocity : Vector2d(walker.ahead - walker.at.position);
      if (way.norm() > 1e-6) wanted = std::atan2(way.y(), way.x());
    }
    walker.yaw += kTick_s * std::clamp(kTurnGain * WrapAngle(wanted - walker.yaw), -kTurnRate, kTurnRate);
  }

  const CrowdEntry crowd_;
  RobotCourse robot_;
  FloorMap map_;
  CrowdCast cast_;
  std::vector<PersonOptions> people_;
  Courses courses_;
  std::vector<Walker> walkers_;
  std::vector<Passer> standing_;
  int tick_ = kFirstTick;
  std::optional<Passer> robot_now_;
  Vector2d robot_from_{0, 0};  ///< Where it truly was last.
  bool foresees_ = false;
  std::vector<int> held_;               ///< By how many walkers each goal is sought.
  std::map<int, FloorMap::Ways> ways_;  ///< To goals that somebody sought.
};

}  // namespace

std::vector<PersonOptions> SimulateCrowd(const CrowdPlan& plan, const CrowdRoom& room) {
  if (plan.crowd.count == 0) return {};
  CrowdSimulation simulation(plan, room);
  simulation.StepTo(int(std::ceil((plan.duration_s + kAfterRun_s) / kTick_s)));
  return simulation.People();
}

class LiveCrowd::Parts {
 public:
  Parts(const CrowdPlan& plan, const CrowdRoom& room) : simulation_(plan, room) {
    simulation_.StepTo(0);
    simulation_.SetRobot([this](double time_s) { return RobotAt(time_s); });
  }

  bool Advance(double time_s, const Vector2d& robot) {
    const int tick = int(std::floor(time_s / kTick_s + 1e-9));
    if (tick == tick_) return false;
    const double before_s = time_s_;
    if (tick_ >= 0) velocity_ = (robot - robot_) / (time_s - before_s);
    time_s_ = time_s;
    robot_ = robot;
    simulation_.StepTo(tick);
    const bool replans = tick / kTicksPerLook != tick_ / kTicksPerLook || tick_ < 0;
    tick_ = tick;
    return replans;
  }

  void Replan(std::span<PersonWalk> walks) {
    const CrowdSimulation::Courses courses = simulation_.Foresee();
    GAITCAM_ASSERT(walks.size() == courses.size());
    for (size_t i = 0; i < courses.size(); ++i) {
      if (courses[i] != simulation_.courses()[i]) walks[i].FollowFrom(time_s_, courses[i]);
    }
  }

  size_t size() const { return simulation_.courses().size(); }

 private:
  /// Before, and as it would go on.
  Vector2d RobotAt(double time_s) const { return robot_ + (time_s - time_s_) * velocity_; }

  CrowdSimulation simulation_;
  int tick_ = -1;
  double time_s_ = 0;
  Vector2d robot_{0, 0}, velocity_{0, 0};
};

LiveCrowd::LiveCrowd(const CrowdPlan& plan, const CrowdRoom& room) : parts_(std::make_unique<Parts>(plan, room)) {}
LiveCrowd::LiveCrowd(LiveCrowd&&) noexcept = default;
LiveCrowd::~LiveCrowd() = default;

size_t LiveCrowd::size() const { return parts_->size(); }

bool LiveCrowd::Advance(double time_s, const Vector2d& robot) { return parts_->Advance(time_s, robot); }

void LiveCrowd::Replan(std::span<PersonWalk> walks) { parts_->Replan(walks); }

}  // namespace gaitcam
