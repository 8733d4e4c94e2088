#include "models/code/people/crowd_cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "algorithms/core/errors.h"
#include "algorithms/core/pose.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr int kAttempts = 1000;
constexpr double kStandRoom_m = 0.4;     // from somebody who stands there to walls and furniture
constexpr double kApart_m = 0.75;        // from one person to the next when the crowd begins
constexpr double kBesideCourse_m = 0.2;  // beyond keep_off_m: where people stay
constexpr double kStanding_m = 0.3;      // of the map, around somebody who stays
constexpr double kQueueStep_m = 0.75;    // from one to the next
constexpr double kKnees_m = 0.3;         // ahead of a seat's middle
constexpr int kLongestQueue = 8;
constexpr double kClearBegin_s = 4;  // walkers begin off the course of that time

Vector2d Unit(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

/// Hue, saturation and value from 0 to 1.
Vector3d FromHsv(double hue, double saturation, double value) {
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + 6 * hue, 6.0);
    return value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

/// Finds room for people one by one.
class Usher {
 public:
  Usher(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot, double duration_s, uint64_t seed,
        FloorMap& map)
      : crowd_(crowd), room_(room), map_(map), random_(seed, "crowd.cast") {
    constexpr double kEvery_s = 0.2;
    for (double t = 0; robot && t <= duration_s; t += kEvery_s) {
      const Vector2d at = robot(t);
      if (t <= kClearBegin_s) begin_.push_back(at);
      if (course_.empty() || (course_.back() - at).norm() > 0.05) course_.push_back(at);
    }
    map_.FindWays();
  }

  CrowdCast Cast() {
    const auto share = [this](double part) { return int(std::lround(part * crowd_.count)); };
    Sit(share(crowd_.sitting));
    for (int left = share(crowd_.queueing); left > 0; left -= kLongestQueue) Queue(std::min(left, kLongestQueue));
    for (int left = share(crowd_.talking); left > 0;) left -= Talk(left);
    const int stand = std::min(share(crowd_.standing), crowd_.count - int(cast_.members.size()));
    for (int i = 0; i < stand; ++i) Stand();
    map_.FindWays();
    const int walkers = crowd_.count - int(cast_.members.size());
    const auto walks_off = [](const CastMember& member) { return member.leave_s > 0; };
    const int leavers = int(std::count_if(cast_.members.begin(), cast_.members.end(), walks_off));
    if (walkers + leavers > 0) FindGoals(walkers + leavers);
    for (int i = 0; i < walkers; ++i) Walk();
    std::stable_sort(cast_.members.begin(), cast_.members.end(),
                     [](const CastMember& a, const CastMember& b) { return a.role < b.role; });
    return std::move(cast_);
  }

 private:
  static double Nearest(const std::vector<Vector2d>& points, const Vector2d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector2d& point : points) nearest = std::min(nearest, (point - p).norm());
    return nearest;
  }
  bool OffCourse(const Vector2d& p) const { return Nearest(course_, p) > crowd_.keep_off_m + kBesideCourse_m; }
  bool HasRoom(const Vector2d& p, double apart_m) const {
    return map_.Clearance(p) >= kStandRoom_m && map_.Reachable(p) && Nearest(taken_, p) >= apart_m;
  }
  Vector2d DrawPlace() {
    const double x = random_.Uniform(room_.min.x(), room_.max.x());
    return {x, random_.Uniform(room_.min.y(), room_.max.y())};
  }

  /// Who walks off some time is no part of the map.
  void StayAWhile(CrowdRole role, const Vector2d& at, double yaw, double leave_s) {
    if (leave_s == 0) {
      Stay(role, at, yaw);
      return;
    }
    cast_.members.push_back({role, at, yaw, 0, leave_s});
    taken_.push_back(at);
  }

  double DrawLeaving() {
    const Vector2d& range = crowd_.leave_s;
    return range.y() > 0 ? std::max(0.1, random_.Uniform(range.x(), range.y())) : 0;
  }

  void Stay(CrowdRole role, const Vector2d& at, double yaw, double seat_m = 0) {
    cast_.members.push_back({role, at, yaw, seat_m, 0});
    taken_.push_back(at);
    map_.AddDisc(at, kStanding_m);
    if (seat_m > 0) map_.AddDisc(at + kKnees_m * Unit(yaw), kStanding_m);
  }

  [[noreturn]] void NoRoom(const std::string& what) const {
    throw BadInput(
        fmt::format("of {} people, {} find room, and then none is left for {}; expected a smaller count, or "
                    "more free floor off the robot's course",
                    crowd_.count, cast_.members.size(), what));
  }

  std::vector<CrowdSpot> ShuffledSpots(bool seats) {
    std::vector<CrowdSpot> spots;
    for (const CrowdSpot& spot : room_.spots) {
      if ((spot.seat_m > 0) == seats) spots.push_back(spot);
    }
    for (int i = int(spots.size()); i > 1; --i) std::swap(spots[size_t(i - 1)], spots[size_t(random_.Index(i))]);
    return spots;
  }

  void Sit(int count) {
    int found = 0;
    for (const CrowdSpot& seat : ShuffledSpots(true)) {
      constexpr double kElbows_m = 0.55;
      if (found == count) return;
      if (!OffCourse(seat.at) || Nearest(taken_, seat.at) < kElbows_m) continue;
      Stay(CrowdRole::kSits, seat.at, seat.yaw, seat.seat_m);
      ++found;
    }
    if (found < count) {
      throw BadInput(
          fmt::format("sitting: {} people want to sit, but the scene has seats off the robot's course for "
                      "{}; expected a smaller share, or more chairs and benches",
                      count, found));
    }
  }

  /// Behind each other, the first before something to look at.
  void Queue(int count) {
    for (const CrowdSpot& head : ShuffledSpots(false)) {
      for (const double bend : {0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2}) {
        const double yaw = head.yaw + bend;
        const auto slot = [&](int i) { return Vector2d(head.at - i * kQueueStep_m * Unit(yaw)); };
        bool free = true;
        for (int i = 0; free && i < count; ++i) free = HasRoom(slot(i), kApart_m - 0.05) && OffCourse(slot(i));
        if (!free) continue;
        for (int i = 0; i < count; ++i) Stay(CrowdRole::kQueues, slot(i), i == 0 ? head.yaw : yaw);
        return;
      }
    }
    NoRoom(fmt::format("a queue of {}", count));
  }

  /// @returns of how many people the group is, two to four and at most `left`; a single one is left to stand.
  int Talk(int left) {
    if (left == 1) {
      Stand();
      return 1;
    }
    int size = std::min(left, 2 + random_.Index(3));
    if (left - size == 1) size = left == 3 ? 3 : size - (size > 2 ? 1 : -1);
    const double radius = std::max(0.45, 0.42 / std::sin(pi / size));
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Vector2d middle = DrawPlace();
      const double turn = random_.Uniform(-pi, pi);
      const auto yaw = [&](int i) { return turn + 2 * pi * i / size; };
      bool free = true;
      for (int i = 0; free && i < size; ++i) {
        const Vector2d at = middle - radius * Unit(yaw(i));
        free = HasRoom(at, kApart_m) && OffCourse(at);
      }
      if (!free) continue;
      const double leave_s = DrawLeaving();
      for (int i = 0; i < size; ++i) {
        StayAWhile(CrowdRole::kTalks, middle - radius * Unit(yaw(i)), WrapAngle(yaw(i)), leave_s);
      }
      return size;
    }
    NoRoom(fmt::format("a group of {}", size));
  }

  void Stand() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Vector2d at = DrawPlace();
      if (!HasRoom(at, kApart_m) || !OffCourse(at)) continue;
      const double yaw = random_.Uniform(-pi, pi);
      StayAWhile(CrowdRole::kStands, at, yaw, DrawLeaving());
      return;
    }
    NoRoom("one who stands");
  }

  void Walk() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Vector2d at = DrawPlace();
      if (!HasRoom(at, kApart_m) || Nearest(begin_, at) < crowd_.keep_off_m + kBesideCourse_m) continue;
      cast_.members.push_back({CrowdRole::kWalks, at, random_.Uniform(-pi, pi), 0, 0});
      taken_.push_back(at);
      return;
    }
    NoRoom("one who walks");
  }

  void FindGoals(int walkers) {
    constexpr size_t kFewest = 2;
    if (!crowd_.goals.empty()) {
      TakeGivenGoals();
      return;
    }
    constexpr int kMost = 60;
    const int wanted = std::min(kMost, walkers + std::max(6, walkers / 2));
    std::vector<CrowdSpot> spots = ShuffledSpots(false);
    std::vector<Vector2d> goals;
    for (int attempt = 0; attempt < kAttempts && int(goals.size()) < wanted; ++attempt) {
      CrowdSpot spot;
      if (attempt % 2 == 0 && !spots.empty()) {
        spot = spots.back();
        spots.pop_back();
      } else {
        spot.at = DrawPlace();
        spot.yaw = random_.Uniform(-pi, pi);
      }
      if (!HasRoom(spot.at, kApart_m) || !OffCourse(spot.at) || Nearest(goals, spot.at) < kApart_m) continue;
      goals.push_back(spot.at);
      cast_.goals.push_back({spot, true});
    }
    if (cast_.goals.size() < kFewest) NoRoom("two goals of those who walk");
  }

  void TakeGivenGoals() {
    for (const Vector2d& at : crowd_.goals) {
      if (!map_.Reachable(at)) {
        throw BadInput(
            fmt::format("goals: [{:g}, {:g}] cannot be reached: it is off the floor, or within {:g} m of a "
                        "wall, of furniture or of somebody who stands",
                        at.x(), at.y(), FloorMap::kPassable_m));
      }
      cast_.goals.push_back({{at, random_.Uniform(-pi, pi), 0}, OffCourse(at)});
    }
  }

  const CrowdEntry& crowd_;
  const CrowdRoom& room_;
  FloorMap& map_;
  RandomStream random_;
  std::vector<Vector2d> course_, begin_;  ///< Of the robot: all, and of the first seconds.
  std::vector<Vector2d> taken_;
  CrowdCast cast_;
};

}  // namespace

PersonOptions DrawCrowdPerson(const CrowdEntry& crowd, RandomStream& random) {
  constexpr double kSigmas = 2.5;  // of heights and speeds, to either side
  const auto normal = [&](double mean, double sigma) {
    return mean + sigma * std::clamp(random.Normal(), -kSigmas, kSigmas);
  };
  static const std::array<Vector3d, 5> kSkins{
      Vector3d(0.92, 0.75, 0.64), {0.82, 0.62, 0.48}, {0.7, 0.5, 0.36}, {0.5, 0.34, 0.24}, {0.34, 0.23, 0.17}};
  static const std::array<Vector3d, 6> kHairs{Vector3d(0.08, 0.07, 0.06), {0.2, 0.13, 0.08},  {0.36, 0.22, 0.12},
                                              {0.72, 0.55, 0.3},          {0.55, 0.54, 0.52}, {0.5, 0.2, 0.08}};
  const double low = crowd.height_m.x(), high = crowd.height_m.y();
  PersonOptions person;
  person.height_m = normal((low + high) / 2, (high - low) / 2 / kSigmas);
  person.girth = normal(1.03, 0.05);
  person.speed_m_s = std::max(0.4, normal(crowd.speed_m_s, crowd.speed_sigma_m_s));
  person.top_rgb = FromHsv(random.Uniform(), random.Uniform(0, 0.75), random.Uniform(0.2, 0.95));
  const double jeans = random.Uniform();
  person.trousers_rgb = jeans < 0.5 ? FromHsv(random.Uniform(0.58, 0.66), random.Uniform(0.3, 0.6), jeans + 0.15)
                                    : FromHsv(random.Uniform(), random.Uniform(0, 0.3), random.Uniform(0.1, 0.7));
  person.shoes_rgb = FromHsv(random.Uniform(), random.Uniform(0, 0.4), random.Uniform(0.1, 0.8));
  const double dark = random.Uniform(0.25, 0.9);
  person.soles_rgb = {dark, dark, 0.96 * dark};
  person.skin_rgb = kSkins[size_t(random.Index(int(kSkins.size())))];
  person.hair_rgb = kHairs[size_t(random.Index(int(kHairs.size())))];
  person.seed = random.Bits() % 1000;
  return person;
}

CrowdCast CastCrowd(const CrowdEntry& crowd, const CrowdRoom& room, const RobotCourse& robot, double duration_s,
                    uint64_t seed, FloorMap& map) {
  return Usher(crowd, room, robot, duration_s, seed, map).Cast();
}

}  // namespace gaitcam
