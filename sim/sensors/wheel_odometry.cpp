#include "sim/sensors/wheel_odometry.h"

#include <cmath>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Where wheel i rolls to, a unit vector in the base's frame.
Eigen::Vector2d Rolling(int wheel) {
  const double at = kPi / 3 + 2 * kPi / 3 * wheel;
  return {-std::sin(at), std::cos(at)};
}

int JointAddress(const mjModel* model, const char* name) {
  const int joint = mj_name2id(model, mjOBJ_JOINT, name);
  GAITCAM_ASSERT(joint >= 0);
  return model->jnt_qposadr[joint];
}

}  // namespace

bool HasOdometry(const Robot& robot) { return robot.kind == Robot::Kind::kHumanoid || robot.sway.empty(); }

Wheels::Wheels(const DriveOptions& nominal, const OdometryOptions& options, bool perfect, RandomStream random)
    : nominal_radius_(nominal.wheel_radius_m),
      nominal_distance_(nominal.wheel_distance_m),
      distance_(nominal.wheel_distance_m),
      random_(random) {
  radius_.fill(nominal_radius_);
  if (perfect) return;
  slip_per_sqrt_m_ = options.slip_per_sqrt_m;
  if (options.ticks_per_turn > 0) tick_rad_ = 2 * kPi / options.ticks_per_turn;
  distance_ *= 1 + 0.01 * random_.Normal(0, options.wheel_distance_pct);
  const double alike = random_.Normal(0, options.wheel_radius_pct);
  for (double& radius : radius_) radius *= 1 + 0.01 * (alike + random_.Normal(0, options.wheel_difference_pct));
}

void Wheels::Roll(const PlanarPose& motion) {
  // Wheels turn with the base: on the average of a little motion they stand as halfway through it.
  const Eigen::Vector2d d = Rotate(motion.position, -0.5 * motion.heading);
  for (int i = 0; i < kCount; ++i) {
    const double travel = Rolling(i).dot(d) + distance_ * motion.heading;
    travel_[size_t(i)] += travel;
    rolled_m_[size_t(i)] += std::abs(travel);
  }
}

PlanarPose Wheels::Read() {
  Eigen::Vector2d d(0, 0);
  double turn = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const double slip = slip_per_sqrt_m_ > 0 ? random_.Normal(0, slip_per_sqrt_m_ * std::sqrt(rolled_m_[i])) : 0;
    turned_rad_[i] += (travel_[i] + slip) / radius_[i];
    travel_[i] = rolled_m_[i] = 0;
    const double reads = tick_rad_ > 0 ? tick_rad_ * std::floor(turned_rad_[i] / tick_rad_) : turned_rad_[i];
    const double way = nominal_radius_ * (reads - std::exchange(read_rad_[i], reads));
    d += 2.0 / kCount * way * Rolling(int(i));
    turn += way / (kCount * nominal_distance_);
  }
  return {Rotate(d, 0.5 * turn), turn};
}

WheelOdometry::WheelOdometry(const World& world, const OdometryOptions& options, bool perfect, uint64_t seed)
    : wheels_(world.robot().drive, options, perfect, RandomStream(seed, "wheels")),
      rate_hz_(options.rate_hz),
      address_{JointAddress(world.model(), "drive_x"), JointAddress(world.model(), "drive_y"),
               JointAddress(world.model(), "drive_yaw")},
      samples_{{world.stamp_ns(), X_OB_.position, X_OB_.heading}} {}

PlanarPose WheelOdometry::Drive(const World& world) const {
  const mjtNum* q = world.data()->qpos;
  return {{q[address_[0]], q[address_[1]]}, q[address_[2]]};
}

void WheelOdometry::Step(const World& world, bool on_floor) {
  const PlanarPose now = Drive(world);
  if (before_ && on_floor) wheels_.Roll(before_->Inverse() * now);
  before_ = now;
  if (world.stamp_ns() < std::llround(double(next_) * 1e9 / rate_hz_)) return;
  ++next_;
  X_OB_ = X_OB_ * wheels_.Read();
  samples_.push_back({world.stamp_ns(), X_OB_.position, X_OB_.heading});
}

std::vector<OdometrySample> WheelOdometry::Take() { return std::exchange(samples_, {}); }

OdometryCalibration WheelDataSheet(const DriveOptions& nominal, const OdometryOptions& options) {
  // Slip moves the base by 2/3 sum_i t_i slip_i and turns it by sum_i slip_i / (3 l). Over 1 m in the worst direction,
  // sum_i |t_i . d| is 2 m, and the longer axis of sum_i t_i t_i^T |t_i . d| is 3 sqrt(3) / 4 m.
  const double l = nominal.wheel_distance_m, slip = options.slip_per_sqrt_m;
  const double scale = 0.01 * options.wheel_radius_pct, bend = 0.01 * options.wheel_difference_pct;
  const double turn_scale = 0.01 * std::hypot(options.wheel_distance_pct, options.wheel_radius_pct);
  OdometryCalibration sheet;
  sheet.rate_hz = options.rate_hz;
  sheet.position_per_sqrt_m =
      std::hypot(slip * 2 / 3 * std::sqrt(0.75 * std::sqrt(3)), scale * std::sqrt(kDataSheetWay_m));
  sheet.heading_per_sqrt_m =
      std::hypot(slip * std::sqrt(2.0) / (3 * l), bend * std::sqrt(1.5) / (3 * l) * std::sqrt(kDataSheetWay_m));
  sheet.heading_per_sqrt_rad = std::hypot(slip / std::sqrt(3 * l), turn_scale * std::sqrt(kDataSheetTurn_rad));
  return sheet;
}

}  // namespace gaitcam
