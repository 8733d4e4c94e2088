#include "scenarios/code/experiments/walk_trial.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sim/sensors/sensors.h"
#include "sim/walking/leg_odometry.h"
#include "sim/walking/walker.h"

namespace gaitcam {
namespace {

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// An empty floor: nothing to bump into and nothing to draw.
Scene EmptyFloor() {
  Scene scene;
  scene.name = "empty";
  scene.floor_min = {-100, -100};
  scene.floor_max = {100, 100};
  return scene;
}

/// What happened along the way.
class Log {
 public:
  Log(const Path& path, WalkTrialResult& result) : path_(path), result_(result) {}

  void AtTick(const World& world, const GaitState& gait) {
    const Pose X_WB = world.X_WB();
    result_.max_tilt_rad = std::max(result_.max_tilt_rad, std::acos(std::clamp(X_WB.R()(2, 2), -1.0, 1.0)));
    if (!standing_) standing_ = HeadOf(world);
    if (gait.step >= 6) AddHead(world);
    if (gait.step == last_step_) return;
    last_step_ = gait.step;
    const Eigen::Vector2d here = X_WB.translation.head<2>();
    if (gait.step == 0) begin_s_ = 1e-9 * double(world.stamp_ns());
    if (gait.step > 0) {
      // Over two steps: the sway from side to side is no way.
      if (gait.step % 2 == 0) {
        result_.distance_m += (here - last_).norm();
        last_ = here;
        end_s_ = 1e-9 * double(world.stamp_ns());
        result_.speed_m_s = result_.distance_m / (end_s_ - begin_s_);
      }
      result_.path_error_m.push_back(path_.DistanceTo(here));
    } else {
      last_ = here;
    }
  }

  void Finish() {
    if (count_ == 0) return;
    result_.head_rate_rms = (rate_square_ / count_).cwiseSqrt();
    const Eigen::Vector3d rms = (stand_square_ / count_).cwiseSqrt();
    result_.head_tilt_rms = rms.head<2>();
    result_.head_height_rms_m = rms.z();
  }

 private:
  /// Roll and pitch, small, and height.
  static Eigen::Vector3d HeadOf(const World& world) {
    const double *up = world.data()->cam_xmat + 6, *at = world.data()->cam_xpos;  // of the camera x right, y up, z back
    return {up[0], up[2], at[2]};
  }

  void AddHead(const World& world) {
    const Eigen::Vector3d moved = HeadOf(world) - *standing_;
    stand_square_ += moved.cwiseProduct(moved);
    ++count_;
    double velocity[6];
    mj_objectVelocity(world.model(), world.data(), mjOBJ_CAMERA, 0, velocity, 1);
    // Camera x right, y up, z back: pitch is about x, yaw about y, roll about -z.
    const Eigen::Vector3d rate(-velocity[2], -velocity[0], velocity[1]);
    rate_square_ += rate.cwiseProduct(rate);
  }

  const Path& path_;
  WalkTrialResult& result_;
  int last_step_ = -1;
  Eigen::Vector2d last_ = Eigen::Vector2d::Zero();
  double begin_s_ = 0, end_s_ = 0;
  std::optional<Eigen::Vector3d> standing_;
  Eigen::Vector3d rate_square_ = Eigen::Vector3d::Zero(), stand_square_ = Eigen::Vector3d::Zero();
  int count_ = 0;
};

}  // namespace

WalkTrialResult RunWalkTrial(const Robot& robot, const GaitOptions& gait, const WalkTrialOptions& options) {
  const double begin = Now();
  WorldCamera camera;
  camera.name = "head";
  World world(robot, EmptyFloor(), options.physics, {camera}, options.seed);
  world.ScaleServos(gait.servo_stiffness, gait.neck_stiffness);
  const auto walker = MakeWalker(robot, world.nominal_model(), gait, options.path, options.physics, {});
  world.SetState(walker->InitialRoot(), walker->InitialJoints());
  SensorSuite sensors(world, options.sensors, options.seed);
  std::optional<LegOdometry> legs;
  if (options.sensors.odometry) legs.emplace(robot, options.sensors.odometry->rate_hz);
  const Path path(options.path, {});
  WalkTrialResult result;
  result.start = PlanarPose(world.X_WB());
  Log log(path, result);

  while (!walker->Finished() && 1e-9 * double(world.stamp_ns()) < options.longest_s) {
    const double control_begin = Now();
    ControlInput input{world.stamp_ns(), sensors.imu(), sensors.ReadJoints(world), {}};
    if (options.path.feedback == PathFeedback::kTruth) input.X_WB = world.X_WB();
    world.SetTargets(walker->Update(input));
    result.control_wall_s += Now() - control_begin;
    const int64_t until = world.stamp_ns() + world.control_period_ns();
    while (world.stamp_ns() < until) {
      world.Step();
      sensors.Step(world);
    }
    const std::vector<ImuSample> imu = sensors.TakeImu();
    if (legs) {
      const std::vector<OdometrySample> samples = legs->Update(imu, {input.joints});
      result.odometry.insert(result.odometry.end(), samples.begin(), samples.end());
    }
    world.record().DropBefore(world.stamp_ns());
    log.AtTick(world, walker->gait());
    if (world.HasFallen()) {
      result.fell = true;
      result.fell_at_m = result.distance_m;
      break;
    }
  }
  log.Finish();
  result.finished = walker->Finished();
  result.end_s = 1e-9 * double(world.stamp_ns());
  result.end = PlanarPose(world.X_WB());
  result.last_qpos.assign(world.data()->qpos, world.data()->qpos + world.model()->nq);
  result.wall_s = Now() - begin;
  return result;
}

}  // namespace gaitcam
