#include "algorithms/slam/hybrid_drive.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/pose.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr double kGoal_m = 0.5;      // a goal farther from all views is off the map
constexpr double kLook_rad_s = 0.3;  // to look all around: a turn takes 21 s, and blurs a picture no more than driving
constexpr double kStart_m = 1.0;     // likewise of where the robot finds itself
constexpr double kArrived_m = 0.03;  // short of the goal
constexpr double kBrake_mps2 = 0.25;

const std::shared_ptr<const RouteMap>& NeedMap(const std::shared_ptr<const RouteMap>& map) {
  if (!map) throw BadInput("hybrid_drive needs a map to drive by; set map to a run of hybrid_slam");
  return map;
}

const Calibration& NeedWheels(const Calibration& calibration) {
  if (calibration.odometry.rate_hz > 0) return calibration;
  throw BadInput("hybrid_drive needs the body's odometry, which the calibration does not have (odometry.rate_hz)");
}

}  // namespace

HybridDrive::HybridDrive(const Calibration& calibration, std::shared_ptr<const RouteMap> map,
                         const HybridDriveOptions& options, uint64_t seed)
    : options_(options),
      sight_(NeedWheels(calibration), options.sight, "hybrid_drive"),
      body_(calibration.odometry, calibration.imu),
      localizer_(calibration, NeedMap(map), options.sight.feature, options.sight.models, options.localizer, seed),
      guard_(calibration, options.guard),
      ways_(*map),
      frame_s_(calibration.frame_rate_hz > 0 ? 1 / calibration.frame_rate_hz : 0),
      map_(std::move(map)) {
  CheckFields(options, "hybrid_drive.");
  drive_.X_BC = calibration.odometry.X_BC;
  drive_.half_view_rad = std::atan(0.5 * calibration.camera.width_px / calibration.camera.fx);
  const Eigen::Vector2d goal_m(options.goal_x_m, options.goal_y_m);
  goal_ = ways_.Nearest(goal_m, kGoal_m);
  if (goal_ >= 0) return;
  const int nearest = ways_.Nearest(goal_m, 1e9);
  const Eigen::Vector2d there = ways_.At(nearest).position;
  throw BadInput("hybrid_drive.goal_x_m: the goal is off the map, whose nearest way passes at " +
                 std::to_string(there.x()) + ", " + std::to_string(there.y()) + " m; expected one within 0.5 m of it");
}

FrameEstimate HybridDrive::Track(const Observation& observation) {
  const int64_t stamp_ns = observation.stamp_ns;
  body_.Add(observation.odometry, observation.imu);
  const MetricModel seen = sight_.See(observation);
  const std::optional<MapLocalizer::Fix> fix = localizer_.Locate(stamp_ns, seen, body_);
  body_.Forget(stamp_ns);
  DriveStep step;
  step.stamp_ns = stamp_ns;
  if (fix) {
    step.confirmed = fix->Sure();
    step.found = fix->found;
    step.places = fix->places;
    step.X_FB = ways_.InFloor(fix->X_WC);
    const bool goes_on = !(fix->view >= 0 && KnowsTheWay(step.X_FB)) && !drive_.steps.empty();
    blind_m_ = goes_on ? blind_m_ + (step.X_FB.position - drive_.steps.back().X_FB.position).norm() : 0;
    if (fix->found) guard_.Forget();
    guard_.See(stamp_ns, ways_.CameraInFloor(fix->X_WC), observation.depth->pixels);
    if (route_.empty() || fix->found) Plan(step.X_FB);
  }
  command_ = Velocity();
  if (fix && !route_.empty()) step.state = Drive(step);
  if (const Velocity* velocity = std::get_if<Velocity>(&command_))
    commanded_.emplace_back(stamp_ns, std::hypot(velocity->forward_mps, velocity->left_mps));
  drive_.steps.push_back(step);
  return AnswerOf(stamp_ns, seen, fix);
}

FrameEstimate HybridDrive::AnswerOf(int64_t stamp_ns, const MetricModel& seen,
                                    const std::optional<MapLocalizer::Fix>& fix) const {
  FrameEstimate answer;
  answer.stamp_ns = stamp_ns;
  answer.features = seen.features.size();
  answer.status = drive_.routes.empty() ? TrackingStatus::kInitializing : TrackingStatus::kLost;
  if (!fix) return answer;
  answer.inliers = fix->inliers;
  answer.matches = fix->matches;
  if (!fix->Sure()) {
    answer.status = TrackingStatus::kLost;
    answer.predicted = fix->X_WC;
    return answer;
  }
  answer.status = TrackingStatus::kTracking;
  answer.pose = fix->X_WC;
  answer.covariance = fix->covariance;
  return answer;
}

/// From where it is. A robot that is off every taught way, or past the last one to its goal, has no route, and stands.
void HybridDrive::Plan(const PlanarPose& X_FB) { Take(ViewsToGoal(X_FB), X_FB); }

/// Another way, none of whose views lies in what is blocked; the old one if there is none.
void HybridDrive::PlanAround(const PlanarPose& X_FB) {
  constexpr double kBlocked_m = 1.5;
  const int start = ways_.Nearest(X_FB, kStart_m);
  if (start < 0) return;
  std::set<int> closed;
  const Eigen::Vector2d block = route_.At(along_m_ + kBlocked_m / 2).position;
  for (int v = 0; v < ways_.size(); ++v) {
    if (v != start && (ways_.At(v).position - block).norm() < kBlocked_m / 2) closed.insert(v);
  }
  const std::vector<int> way = ways_.Shortest(start, goal_, closed);
  if (!way.empty()) Take(way, X_FB);
}

void HybridDrive::Take(const std::vector<int>& views, const PlanarPose& X_FB) {
  DriveRoute route{int(drive_.steps.size()), {}};
  std::vector<PlanarPose> poses;
  for (const int view : views) {
    route.views_ns.push_back(map_->graph.nodes[size_t(view)].stamp_ns);
    poses.push_back(ways_.At(view));
  }
  route_ = Route(poses);
  along_m_ = route_.Nearest(X_FB.position, 0, kStart_m);
  if (!views.empty()) drive_.routes.push_back(std::move(route));
}

/// Arrived is who sees that he is there, or who has looked through the whole map and found himself nowhere else.
DriveState HybridDrive::Drive(const DriveStep& step) {
  const PlanarPose& X_FB = step.X_FB;
  constexpr double kBack_m = 0.3, kOn_m = 0.8;  // how far from where it was a frame ago it may be along the route
  along_m_ = route_.Nearest(X_FB.position, along_m_ - kBack_m, along_m_ + kOn_m);
  const double going_m = GoingStill(step.stamp_ns);
  const double left_m = route_.length_m() - along_m_;
  if (left_m <= kArrived_m) {
    if (!Doubts(step)) {
      command_ = EndWalk();
      return DriveState::kArrived;
    }
    if (step.places == 1) return DriveState::kSearching;
    blind_m_ = 2 * options_.blind_m;  // what tells the places apart may be behind it
  }
  if (LooksAround(step)) return DriveState::kSearching;
  const double free_m = guard_.FreeWay([&](double ahead_m) { return route_.At(along_m_ + ahead_m).position; });
  const double allowed = std::min(SpeedBefore(free_m - going_m),
                                  guard_.SpeedAmongWalkers({kBrake_mps2, frame_s_ + options_.late_s, going_m}));
  const double speed = std::min({options_.speed_mps, allowed, SpeedBefore(left_m - going_m) + 0.02});
  if (speed >= 0.02) {
    waits_since_ns_.reset();
    command_ = Steer(X_FB, speed);
    return allowed < options_.speed_mps ? DriveState::kWaiting : DriveState::kDriving;
  }
  command_ = Velocity();
  if (!waits_since_ns_) waits_since_ns_ = step.stamp_ns;
  if (1e-9 * double(step.stamp_ns - *waits_since_ns_) >= options_.patience_s) {
    waits_since_ns_ = step.stamp_ns;
    PlanAround(X_FB);
  }
  return DriveState::kWaiting;
}

/// The shortest way, from the view of the map that is nearest; none off the taught ways.
std::vector<int> HybridDrive::ViewsToGoal(const PlanarPose& X_FB) const {
  const int start = ways_.Nearest(X_FB, kStart_m);
  return start < 0 ? std::vector<int>() : ways_.Shortest(start, goal_);
}

Route HybridDrive::WayFrom(const PlanarPose& X_FB) const {
  std::vector<PlanarPose> poses;
  for (const int view : ViewsToGoal(X_FB)) poses.push_back(ways_.At(view));
  return Route(poses);
}

/// Wherever else it may be, it would go in the same direction now, and a metre on.
bool HybridDrive::KnowsTheWay(const PlanarPose& X_FB) const {
  constexpr double kSame_rad = 0.4;
  const std::vector<Pose> elsewhere = localizer_.Elsewhere();
  if (elsewhere.empty()) return true;
  const Route here = WayFrom(X_FB);
  const auto direction = [](const Route& way, const PlanarPose& from, double ahead_m) {
    return way.DirectionAt(way.Nearest(from.position, 0, kStart_m) + ahead_m) - from.heading;
  };
  return std::all_of(elsewhere.begin(), elsewhere.end(), [&](const Pose& X_WC) {
    const PlanarPose X_FE = ways_.InFloor(X_WC);
    const Route there = WayFrom(X_FE);
    if (here.empty() || there.empty()) return false;
    const auto same = [&](double ahead_m) {
      return std::abs(WrapAngle(direction(here, X_FB, ahead_m) - direction(there, X_FE, ahead_m))) < kSame_rad;
    };
    return same(0) && same(1);
  });
}

/// Who is not sure that he is at his goal, and has not yet looked through the whole map for long enough.
bool HybridDrive::Doubts(const DriveStep& step) const {
  constexpr int kLooked = 4;  // frames in which the whole map is searched
  if (step.confirmed) return false;
  return step.places > 1 || localizer_.unconfirmed_frames() <= options_.localizer.unconfirmed_frames + kLooked;
}

/// Once all around, wherever it has gone blindly for `blind_m`; after the last time it stands.
bool HybridDrive::LooksAround(const DriveStep& step) {
  constexpr int kLooks = 2;
  if (step.confirmed) looks_ = 0;
  if (blind_m_ <= options_.blind_m) {
    looks_since_ns_.reset();
    return false;
  }
  if (!looks_since_ns_) looks_since_ns_ = step.stamp_ns;
  const bool all_around = 1e-9 * double(step.stamp_ns - *looks_since_ns_) > 2 * kPi / kLook_rad_s;
  command_ = looks_ < kLooks && !all_around ? Velocity{0, 0, kLook_rad_s} : Velocity();
  if (!all_around || looks_ >= kLooks) return true;
  looks_since_ns_.reset();
  if (++looks_ < kLooks) blind_m_ = 0;  // on by its wheels: it may be where nothing of the map is to be seen
  return true;
}

/// The way that it goes by what was commanded in the last `late_s` and is not answered yet.
double HybridDrive::GoingStill(int64_t stamp_ns) {
  const auto since_s = [&](int64_t then_ns) { return 1e-9 * double(stamp_ns - then_ns); };
  double going_m = 0, until_s = 0;
  for (size_t i = commanded_.size(); i-- > 0;) {
    const double from_s = std::min(since_s(commanded_[i].first), options_.late_s);
    going_m += commanded_[i].second * (from_s - until_s);
    until_s = from_s;
  }
  while (commanded_.size() > 1 && since_s(commanded_[1].first) >= options_.late_s) commanded_.pop_front();
  return going_m;
}

/// From which the base comes to stand in so many metres.
double HybridDrive::SpeedBefore(double free_m) const { return std::sqrt(2 * kBrake_mps2 * std::max(0.0, free_m)); }

/// Eq. 6.5 as a velocity in the body's frame.
Velocity HybridDrive::Steer(const PlanarPose& X_FB, double speed_mps) const {
  constexpr double kMost_mps = 0.15;  // sideways
  const double direction = route_.DirectionAt(along_m_);
  const Eigen::Vector2d tangent(std::cos(direction), std::sin(direction)), left(-tangent.y(), tangent.x());
  const double beside_m = left.dot(X_FB.position - route_.At(along_m_).position);
  const double back_mps = std::clamp(-options_.lateral_gain * beside_m, -kMost_mps, kMost_mps);
  const Eigen::Vector2d velocity = Rotate(speed_mps * tangent + back_mps * left, -X_FB.heading);
  constexpr double kStep_m = 0.1;
  const double turn_per_m =
      (route_.At(along_m_ + kStep_m).heading - route_.At(along_m_ - kStep_m).heading) / (2 * kStep_m);
  const double turned = WrapAngle(X_FB.heading - route_.At(along_m_).heading);
  return {velocity.x(), velocity.y(), speed_mps * turn_per_m - options_.heading_gain * turned};
}

}  // namespace gaitcam
