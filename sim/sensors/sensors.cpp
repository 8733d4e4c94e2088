#include "sim/sensors/sensors.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

int SensorAddress(const mjModel* model, const char* name) {
  const int id = mj_name2id(model, mjOBJ_SENSOR, name);
  GAITCAM_ASSERT(id >= 0);
  return model->sensor_adr[id];
}

Eigen::Vector3d ReadSensor(const World& world, int address) {
  return Eigen::Map<const Eigen::Vector3d>(world.data()->sensordata + address);
}

Eigen::Vector3d NormalVector(RandomStream& random) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = random.Normal();
  return v;
}

/// An ideal IMU's reading at rest: specific force against gravity.
Eigen::Vector3d RestForce(const World& world) {
  const Robot& robot = world.robot();
  const Pose X_WI = world.X_WB() * LinkPoses(robot, world.JointPositions())[robot.imu.link] * robot.imu.X_LS;
  return X_WI.R().transpose() * Eigen::Vector3d(0, 0, -world.model()->opt.gravity[2]);
}

}  // namespace

ImuCalibration CalibrateImu(const Robot& robot, const SensorOptions& options, const Pose& X_MC,
                            const std::vector<double>& rest_joints) {
  const std::vector<Pose> X_RL = LinkPoses(robot, rest_joints);
  const Pose X_RC = X_RL[robot.camera.link] * robot.camera.X_LS * X_MC;
  ImuCalibration calibration;
  calibration.rate_hz = options.imu_rate_hz;
  calibration.X_CI = X_RC.Inverse() * X_RL[robot.imu.link] * robot.imu.X_LS;
  if (options.perfect) return calibration;
  calibration.gyro_noise_density = options.gyro_noise_density;
  calibration.gyro_random_walk = options.gyro_random_walk;
  calibration.accel_noise_density = options.accel_noise_density;
  calibration.accel_random_walk = options.accel_random_walk;
  return calibration;
}

OdometryCalibration CalibrateWheels(const Robot& robot, const SensorOptions& options) {
  if (!options.odometry || robot.kind != Robot::Kind::kOmniBase) return {};
  if (!options.perfect) return WheelDataSheet(robot.drive, *options.odometry);
  OdometryCalibration exact;
  exact.rate_hz = options.odometry->rate_hz;
  return exact;
}

WindowMean::WindowMean(double rate_hz, int64_t now_ns) : period_ns_(1e9 / rate_hz) {
  window_ = int64_t(std::floor(double(now_ns) / period_ns_ + 0.5));
  filled_until_ = Boundary(window_);
}

int64_t WindowMean::Boundary(int64_t n) const { return std::llround((double(n) - 0.5) * period_ns_); }

void WindowMean::Extend(int64_t until_ns, const Eigen::Vector3d& value) {
  GAITCAM_ASSERT(until_ns >= filled_until_);
  while (until_ns >= Boundary(window_ + 1)) {
    const int64_t begin = Boundary(window_), end = Boundary(window_ + 1);
    sum_ += double(end - filled_until_) * value;
    done_.push_back(sum_ / double(end - begin));
    sum_.setZero();
    filled_until_ = end;
    ++window_;
  }
  sum_ += double(until_ns - filled_until_) * value;
  filled_until_ = until_ns;
}

std::optional<Eigen::Vector3d> WindowMean::Take() {
  if (done_.empty()) return std::nullopt;
  const Eigen::Vector3d mean = done_.front();
  done_.pop_front();
  return mean;
}

SensorSuite::SensorSuite(const World& world, const SensorOptions& options, uint64_t seed)
    : options_(options),
      timestep_ns_(world.timestep_ns()),
      gyro_address_(SensorAddress(world.model(), "gyro")),
      accelerometer_address_(SensorAddress(world.model(), "accelerometer")),
      gyro_(options.imu_rate_hz, world.stamp_ns()),
      accelerometer_(options.imu_rate_hz, world.stamp_ns()),
      imu_random_(seed, "imu"),
      encoder_random_(seed, "encoders") {
  CheckFields(options, "sensors.");
  if (options.odometry) CheckFields(*options.odometry, "sensors.odometry.");
  CheckRates();
  if (options.odometry && !HasOdometry(world.robot())) {
    throw BadOption("sensors.odometry: " + world.robot().name +
                    " is carried and has neither wheels nor legs; expected no such block");
  }
  if (options.odometry && world.robot().kind == Robot::Kind::kOmniBase)
    wheels_.emplace(world, *options.odometry, options.perfect, seed);
  if (!options.perfect) {
    gyro_bias_ = options.gyro_bias * NormalVector(imu_random_);
    accelerometer_bias_ = options.accel_bias * NormalVector(imu_random_);
  }
  sample_ = gyro_.window();
  // Until now the robot stood still.
  latest_.stamp_ns = world.stamp_ns();
  latest_.specific_force = RestForce(world);
  gyro_.Extend(std::max(world.stamp_ns(), gyro_.until_ns()), Eigen::Vector3d::Zero());
  accelerometer_.Extend(std::max(world.stamp_ns() - timestep_ns_ / 2, accelerometer_.until_ns()),
                        latest_.specific_force);
}

void SensorSuite::CheckRates() const {
  const double highest = 1e9 / double(timestep_ns_);
  const auto check = [&](const char* key, double rate_hz) {
    if (rate_hz <= highest * (1 + 1e-9)) return;
    throw BadOption(
        fmt::format("sensors.{} = {}: expected at most {}, one sample per physics step", key, rate_hz, highest));
  };
  check("imu_rate_hz", options_.imu_rate_hz);
  if (options_.odometry) check("odometry.rate_hz", options_.odometry->rate_hz);
}

void SensorSuite::Step(const World& world, bool on_floor) {
  if (wheels_) wheels_->Step(world, on_floor);
  gyro_.Extend(world.stamp_ns(), ReadSensor(world, gyro_address_));
  accelerometer_.Extend(world.stamp_ns() - timestep_ns_ / 2, ReadSensor(world, accelerometer_address_));
  while (const auto force = accelerometer_.Take()) {  // the later one of the two
    ImuSample sample;
    sample.stamp_ns = std::llround(double(sample_++) * 1e9 / options_.imu_rate_hz);
    sample.specific_force = *force;
    sample.angular_rate = gyro_.Take().value();
    if (!options_.perfect) AddNoise(sample);
    latest_ = sample;
    samples_.push_back(sample);
  }
}

void SensorSuite::AddNoise(ImuSample& sample) {
  const double root_rate = std::sqrt(options_.imu_rate_hz);
  sample.angular_rate += gyro_bias_ + options_.gyro_noise_density * root_rate * NormalVector(imu_random_);
  sample.specific_force += accelerometer_bias_ + options_.accel_noise_density * root_rate * NormalVector(imu_random_);
  gyro_bias_ += options_.gyro_random_walk / root_rate * NormalVector(imu_random_);
  accelerometer_bias_ += options_.accel_random_walk / root_rate * NormalVector(imu_random_);
}

std::vector<ImuSample> SensorSuite::TakeImu() { return std::exchange(samples_, {}); }

std::vector<OdometrySample> SensorSuite::TakeOdometry() {
  return wheels_ ? wheels_->Take() : std::vector<OdometrySample>();
}

JointSample SensorSuite::ReadJoints(const World& world) {
  JointSample sample;
  sample.stamp_ns = world.stamp_ns();
  sample.position = world.JointPositions();
  sample.left_contact = world.FootForce(0) > options_.contact_threshold_n;
  sample.right_contact = world.FootForce(1) > options_.contact_threshold_n;
  if (options_.perfect) return sample;
  const double step = options_.encoder_resolution;
  for (size_t i = 0; i < sample.position.size(); ++i) {
    if (world.robot().joints[i].kind == RobotJoint::Kind::kFixed) continue;
    double& q = sample.position[i];
    q += options_.encoder_noise * encoder_random_.Normal();
    if (step > 0) q = step * std::round(q / step);
  }
  return sample;
}

}  // namespace gaitcam
