#include "models/code/people/crowd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "algorithms/core/pose.h"
#include "models/code/people/crowd_forces.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kTick_s = 0.05;
constexpr int kTicksPerPose = 2, kTicksPerLook = 4;   // from one pose of a course, one look ahead, to the next
constexpr double kRecorded_s = -2, kScatter_s = -10;  // before the run: until then people scatter
constexpr double kAfterRun_s = 1;
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
  CrowdSimulation(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot, double duration_s,
                  uint64_t seed)
      : crowd_(crowd), robot_(robot), end_s_(duration_s + kAfterRun_s), map_(room.min, room.max, room.obstacles) {
    cast_ = CastCrowd(crowd, room, robot, duration_s, seed, map_);
    for (size_t i = 0; i < cast_.members.size(); ++i) {
      const CastMember& member = cast_.members[i];
      RandomStream random(seed, fmt::format("crowd.person{}", i));
      people_.push_back(DrawCrowdPerson(crowd, random));
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

  std::vector<PersonOptions> Run() {
    const int first = int(std::lround(kScatter_s / kTick_s)), record = int(std::lround(kRecorded_s / kTick_s));
    const int last = walkers_.empty() ? first : int(std::ceil(end_s_ / kTick_s));
    for (int step = first; step < last; ++step) {
      if (step >= record && (step - record) % kTicksPerPose == 0) Record();
      Advance(step * kTick_s, (step - first) % kTicksPerLook == 0);
    }
    for (size_t i = 0; i < people_.size(); ++i) {
      people_[i].name = fmt::format("crowd{}", i);
      people_[i].path = {courses_[i]->poses[0].head<2>()};
      people_[i].course = courses_[i];
    }
    return std::move(people_);
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
        if (robot_now_) p += Overlap(p - robot_now_->position, crowd_.keep_off_m);
        const double clearance = map_.Clearance(p);
        if (clearance < kCrowdFromWalls_m) p += (kCrowdFromWalls_m - clearance) * map_.Away(p);
      }
    }
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

  const CrowdEntry& crowd_;
  const RobotCourse& robot_;
  const double end_s_;
  FloorMap map_;
  CrowdCast cast_;
  std::vector<PersonOptions> people_;
  std::vector<std::shared_ptr<PersonCourse>> courses_;
  std::vector<Walker> walkers_;
  std::vector<Passer> standing_;
  std::optional<Passer> robot_now_;
  std::vector<int> held_;               ///< By how many walkers each goal is sought.
  std::map<int, FloorMap::Ways> ways_;  ///< To goals that somebody sought.
};

}  // namespace

std::vector<PersonOptions> SimulateCrowd(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot,
                                         double duration_s, uint64_t seed) {
  if (crowd.count == 0) return {};
  return CrowdSimulation(crowd, room, robot, duration_s, crowd.seed.value_or(seed)).Run();
}

}  // namespace gaitcam
