/// What the wheels of an omni base say of its way over the floor.
///
/// Three omni wheels stand at 60, 180 and 300 degrees about the middle and roll across those directions. Wheel i of
/// direction t_i, radius r_i at distance l from the middle turns, while the base moves by (d, theta) in its own frame,
///   phi_i = (t_i . d + l theta + slip_i) / r_i,   slip_i ~ N(0, s^2 |t_i . d + l theta|),
/// and its encoder counts whole ticks. The base's computer knows the nominal r and l alone and solves for (d, theta):
///   theta = sum_i r phi_i / (3 l),   d = 2/3 sum_i t_i r phi_i.
/// Errors of r_i and l are systematic (Borenstein and Feng, "Measurement and correction of systematic odometry errors
/// in mobile robots", 1996); the variance of slip grows with the way rolled (Siegwart and Nourbakhsh, "Introduction to
/// Autonomous Mobile Robots", eq. 5.8). The physics know no wheels (Robot::drive): slip is of this model alone.

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/random.h"
#include "sim/sensors/odometry_options.h"
#include "sim/world/world.h"

namespace gaitcam {

/// Whether a body has something to measure its way by: wheels or legs. What somebody carries has not.
bool HasOdometry(const Robot& robot);

/// Readings of wheels that turn and slip as they are told.
class Wheels {
 public:
  static constexpr int kCount = 3;

  /// @param nominal what the base's computer knows. @param options errors. @param perfect no errors, no ticks.
  Wheels(const DriveOptions& nominal, const OdometryOptions& options, bool perfect, RandomStream random);

  /// The base moved a little. @param motion of its frame, in its frame before.
  void Roll(const PlanarPose& motion);
  /// The motion since the last call as the base's computer reckons it.
  PlanarPose Read();

 private:
  double nominal_radius_, nominal_distance_, tick_rad_ = 0, slip_per_sqrt_m_ = 0, distance_;
  std::array<double, kCount> radius_;
  std::array<double, kCount> travel_{}, rolled_m_{};  ///< Since the last reading; the second never decreases.
  std::array<double, kCount> turned_rad_{}, read_rad_{};
  RandomStream random_;
};

/// The wheels' odometry of a base that moves through a world: a sample at once, and one per period of the rate.
class WheelOdometry {
 public:
  /// @pre the robot has wheels.
  WheelOdometry(const World& world, const OdometryOptions& options, bool perfect, uint64_t seed);

  /// Call after each World::Step. @param on_floor if not, the wheels hang in the air and do not roll.
  void Step(const World& world, bool on_floor = true);
  /// All samples since the last call, in time order.
  std::vector<OdometrySample> Take();

 private:
  PlanarPose Drive(const World& world) const;

  Wheels wheels_;
  double rate_hz_;
  std::array<int, 3> address_;        ///< Of x, y and yaw of the drive in qpos.
  std::optional<PlanarPose> before_;  ///< Where the drive was; at first it stands wherever it is put.
  PlanarPose X_OB_;
  int64_t next_ = 1;
  std::vector<OdometrySample> samples_;
};

/// What a data sheet of the wheels would say. Systematic errors grow with the way and turn, not with the root of them:
/// they count as much as they amount to after kDataSheetWay_m and kDataSheetTurn_rad.
OdometryCalibration WheelDataSheet(const DriveOptions& nominal, const OdometryOptions& options);

}  // namespace gaitcam
