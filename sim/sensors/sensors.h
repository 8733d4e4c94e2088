/// What the robot's own sensors read: inertial measurement unit, joint encoders, foot switches, odometry of wheels.
///
/// Noise follows data sheets, as in Woodman, "An introduction to inertial navigation" (2007), sections 3.2 and 4.2:
/// white noise of density n and a bias that walks with density b. A reading is the mean over one sample period T = 1 /
/// rate, so
///   reading = true mean + bias + n / sqrt(T) w_k,   bias_{k+1} = bias_k + b sqrt(T) u_k,   w_k, u_k ~ N(0, 1) per
///   axis.

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/random.h"
#include "models/code/robots/robot.h"
#include "sim/sensors/odometry_options.h"
#include "sim/sensors/wheel_odometry.h"
#include "sim/world/world.h"

namespace gaitcam {

struct SensorOptions {
  using DescribedTag = void;

  double imu_rate_hz = 250;
  double gyro_noise_density = 1.7e-4;
  double gyro_random_walk = 2e-5;
  double gyro_bias = 0.005;
  double accel_noise_density = 2e-3;
  double accel_random_walk = 3e-3;
  double accel_bias = 0.05;
  double encoder_noise = 5e-4;
  double encoder_resolution = 1.534e-3;
  double contact_threshold_n = 0.5;
  std::optional<OdometryOptions> odometry;
  bool perfect = false;
};

template <class Visitor>
void VisitFields(Visitor& visit, SensorOptions& o) {
  visit("imu_rate_hz", o.imu_rate_hz, Between(1, 10000), "at most one sample per physics step");
  visit("gyro_noise_density", o.gyro_noise_density, Between(0, 1), "white noise of the gyroscope, rad/s/sqrt(Hz)");
  visit("gyro_random_walk", o.gyro_random_walk, Between(0, 1), "of the gyroscope's bias, rad/s^2/sqrt(Hz)");
  visit("gyro_bias", o.gyro_bias, Between(0, 1), "rad/s, standard deviation per axis of the bias at switching on");
  visit("accel_noise_density", o.accel_noise_density, Between(0, 10),
        "white noise of the accelerometer, m/s^2/sqrt(Hz)");
  visit("accel_random_walk", o.accel_random_walk, Between(0, 10), "of the accelerometer's bias, m/s^3/sqrt(Hz)");
  visit("accel_bias", o.accel_bias, Between(0, 10), "m/s^2, standard deviation per axis of the bias at switching on");
  visit("encoder_noise", o.encoder_noise, Between(0, 0.1), "standard deviation; rad, m for sliding joints");
  visit("encoder_resolution", o.encoder_resolution, Between(0, 0.1),
        "rad or m, by default 12 bit per turn; 0 is continuous");
  visit("contact_threshold_n", o.contact_threshold_n, Between(0, 1000), "force that closes a foot's switch");
  visit("odometry", o.odometry, Nested(),
        "how wheels or legs say that the body has moved over the floor; absent: they say nothing");
  visit("perfect", o.perfect, Nested(), "no noise, bias or rounding");
}

/// The calibration of the IMU: its noise densities, and its pose relative to a camera.
/// @param X_MC of that camera in the robot's camera mount.
/// @param rest_joints joint positions (order of Robot::joints) at which X_CI holds: the neck at rest.
ImuCalibration CalibrateImu(const Robot& robot, const SensorOptions& options, const Pose& X_MC,
                            const std::vector<double>& rest_joints);

/// The data sheet of the wheels' odometry, if there is any; its X_BC is left at the identity.
OdometryCalibration CalibrateWheels(const Robot& robot, const SensorOptions& options);

/// Splits a piecewise constant signal into windows of one sample period and averages it over each.
class WindowMean {
 public:
  /// Window n spans [(n - 1/2) T, (n + 1/2) T); the first one contains `now_ns`.
  explicit WindowMean(double rate_hz, int64_t now_ns = 0);
  int64_t window() const { return window_; }  ///< The current one.
  int64_t until_ns() const { return filled_until_; }
  /// The signal is `value` from the end of the last call's span until `until_ns`.
  void Extend(int64_t until_ns, const Eigen::Vector3d& value);
  /// The mean over the oldest complete window not yet returned.
  std::optional<Eigen::Vector3d> Take();

 private:
  int64_t Boundary(int64_t n) const;

  double period_ns_;
  int64_t window_ = 0, filled_until_ = 0;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  std::deque<Eigen::Vector3d> done_;
};

/// The robot's sensors. IMU samples are stamped with the middle of their averaging window, n / rate; a sample is known
/// half a period and half a physics step later.
///
/// MuJoCo's semi-implicit Euler step is the leapfrog scheme: between two stamps the mechanism moves with the velocity
/// of the later one, and that velocity changes at the stamps. So the gyro's value belongs to the interval before its
/// stamp and the accelerometer's to half a step on both sides of its own. With these windows the gyroscope's readings
/// integrate to the true rotation and the accelerometer's to the true change of velocity.
class SensorSuite {
 public:
  /// @throws BadOption if a field is out of range, a rate exceeds one sample per physics step, or odometry is asked of
  /// what somebody carries.
  SensorSuite(const World& world, const SensorOptions& options, uint64_t seed);

  /// Call after each World::Step. @param on_floor whether wheels, if it has some, touch the floor.
  void Step(const World& world, bool on_floor = true);

  /// The newest sample; before the first one, what an ideal IMU reads at rest.
  const ImuSample& imu() const { return latest_; }
  /// All samples since the last call, in time order.
  std::vector<ImuSample> TakeImu();
  /// All samples of the wheels' odometry since the last call, in time order; none of a robot on legs.
  std::vector<OdometrySample> TakeOdometry();
  /// Reads encoders and foot switches now, with new noise at each call.
  JointSample ReadJoints(const World& world);

 private:
  void AddNoise(ImuSample& sample);
  void CheckRates() const;

  SensorOptions options_;
  int64_t timestep_ns_;
  int64_t sample_ = 0;
  int gyro_address_, accelerometer_address_;
  WindowMean gyro_, accelerometer_;
  RandomStream imu_random_, encoder_random_;
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero(), accelerometer_bias_ = Eigen::Vector3d::Zero();
  ImuSample latest_;
  std::vector<ImuSample> samples_;
  std::optional<WheelOdometry> wheels_;
};

}  // namespace gaitcam
