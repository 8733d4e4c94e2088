#include "sim/simulation.h"

#include <numbers>

#include "algorithms/core/errors.h"
#include "sim/walker.h"

namespace gaitcam {
namespace {

Pose StartPose(const gaitcam::Place& place, const SimulationOptions& options) {
  Eigen::Vector3d start = place.start;
  if (options.start) start = {options.start->x(), options.start->y(), options.start->z() * std::numbers::pi / 180};
  return {RotZ(start.z()), Eigen::Vector3d(start.x(), start.y(), 0)};
}

std::unique_ptr<Controller> MakeController(const Robot& robot, const mjModel* nominal, const SimulationOptions& options,
                                           const Pose& start) {
  if (robot.kind == Robot::Kind::kOmniBase) return MakeOmniDrive(robot, options.drive, options.path, start);
  return MakeWalker(robot, nominal, options.gait, options.path, options.physics, start);
}

Pose PoseFrom(const double* position, const double* matrix) {
  const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix);
  return {R, Eigen::Vector3d(position[0], position[1], position[2])};
}

/// By the nominal kinematics, soles on the floor.
StandingCamera StandingCameraOf(const Robot& robot, const Pose& X_MC, const Pose& X_WR,
                                const std::vector<double>& joints) {
  const Pose X_WC = X_WR * LinkPoses(robot, joints)[robot.camera.link] * robot.camera.X_LS * X_MC;
  return {X_WC.translation.z(), X_WC.R().transpose() * Eigen::Vector3d::UnitZ()};
}

double ExpectedTime(const Robot& robot, const SimulationOptions& options) {
  const double path_s = robot.kind == Robot::Kind::kOmniBase ? EstimateDrivingTime(options.drive, options.path)
                                                             : EstimateWalkingTime(options.gait, options.path);
  return options.duration_s > 0 ? std::min(options.duration_s, path_s) : path_s;
}

}  // namespace

void CheckSimulation(const Robot& robot, const gaitcam::Place& place, const SimulationOptions& options, uint64_t seed) {
  options.camera.Check();
  gaitcam::Place floor;  // the robot is asked, not the place: an empty floor compiles in no time
  floor.start = place.start;
  const World world(robot, floor, options.physics, {}, seed);
  MakeController(robot, world.nominal_model(), options, StartPose(place, options));
  SensorSuite(world, options.sensors, seed);
}

Simulation::Simulation(const Robot& robot, const gaitcam::Place& place, const SimulationOptions& options, uint64_t seed)
    : options_(options),
      rig_(options.camera, seed),
      world_(robot, place, options.physics, rig_.WorldCameras(), seed),
      controller_(MakeController(robot, world_.nominal_model(), options, StartPose(place, options))),
      sensors_(world_, options.sensors, seed),
      renderer_(world_.model(), rig_.MakeRendererOptions()),
      calibration_(rig_.MakeCalibration()),
      middle_(mj_makeData(world_.model())) {
  if (robot.kind == Robot::Kind::kHumanoid) {
    world_.ScaleServos(options.gait.servo_stiffness, options.gait.neck_stiffness);
  }
  world_.Place(controller_->InitialRoot(), controller_->InitialJoints());
  last_position_ = world_.X_WB().translation.head<2>();
  const Pose& X_MC = rig_.WorldCameras().front().X_MC;
  calibration_.imu = CalibrateImu(robot, options.sensors, X_MC, controller_->InitialJoints());
  calibration_.standing = StandingCameraOf(robot, X_MC, controller_->InitialRoot(), controller_->InitialJoints());
}

Simulation::~Simulation() = default;

int64_t Simulation::ExpectedFrames() const {
  return int64_t(ExpectedTime(world_.robot(), options_) * options_.camera.rate_hz);
}

void Simulation::End(SimulationStatus status) {
  status_ = status;
  end_time_s_ = double(world_.stamp_ns()) * 1e-9;
}

/// One control period: read the sensors, tell the servos.
void Simulation::Control() {
  ControlInput input;
  input.stamp_ns = world_.stamp_ns();
  input.imu = sensors_.imu();
  input.joints = sensors_.ReadJoints(world_);
  joints_.push_back(input.joints);
  if (options_.path.feedback == "truth") input.X_WB = world_.X_WB();
  world_.SetTargets(controller_->Update(input));
  const Eigen::Vector2d position = world_.X_WB().translation.head<2>();
  distance_m_ += (position - last_position_).norm();
  last_position_ = position;
}

/// @returns false if the run ended before `stamp_ns`.
bool Simulation::WalkUntil(int64_t stamp_ns) {
  while (world_.stamp_ns() < stamp_ns) {
    if (world_.stamp_ns() % world_.control_period_ns() == 0) Control();
    world_.Step();
    sensors_.Step(world_);
    if (world_.HasFallen()) {
      End(SimulationStatus::kFell);
      return false;
    }
    const bool time_is_up = options_.duration_s > 0 && double(world_.stamp_ns()) * 1e-9 >= options_.duration_s;
    if (time_is_up || controller_->Finished()) {
      End(SimulationStatus::kFinished);
      return false;
    }
  }
  end_time_s_ = double(world_.stamp_ns()) * 1e-9;
  return true;
}

/// What is true of the mechanism itself at mid-exposure, and of gait and contacts at the shutter's close.
void Simulation::FillTruth(int64_t stamp_ns, FrameTruth& truth) {
  const mjModel* model = world_.model();
  world_.record().Evaluate(model, stamp_ns, middle_.get());
  const int root = mj_name2id(model, mjOBJ_BODY, world_.robot().links[0].name.c_str());
  const int imu = mj_name2id(model, mjOBJ_SITE, "imu");
  GAITCAM_ASSERT(root >= 0 && imu >= 0);
  truth.stamp_ns = stamp_ns;
  truth.X_WB = PoseFrom(middle_->xpos + 3 * root, middle_->xmat + 9 * root);
  truth.X_WI = PoseFrom(middle_->site_xpos + 3 * imu, middle_->site_xmat + 9 * imu);
  truth.gait = controller_->gait();
  truth.left_contact = world_.FootContact(0);
  truth.right_contact = world_.FootContact(1);
}

std::optional<SimulatedFrame> Simulation::Next(const TruthOptions& truth) {
  if (status_ != SimulationStatus::kWalking) return std::nullopt;
  const int64_t stamp_ns = rig_.FrameStamp(frame_);
  const ShutterInterval shutter = rig_.Shutter(stamp_ns);
  if (!WalkUntil(shutter.close_ns)) return std::nullopt;
  world_.record().DropBefore(shutter.open_ns);
  RigFrame exposed = rig_.Expose(renderer_, world_.record(), frame_++, truth);

  SimulatedFrame frame;
  frame.observation.stamp_ns = stamp_ns;
  frame.observation.exposure_ms = options_.camera.exposure.exposure_ms;
  frame.observation.image = std::move(exposed.left.image);
  if (exposed.right) frame.observation.right = std::move(exposed.right->image);
  frame.observation.depth = std::move(exposed.depth);
  frame.observation.imu = sensors_.TakeImu();
  frame.observation.joints = std::exchange(joints_, {});
  frame.truth.camera = std::move(exposed.left.truth);
  FillTruth(stamp_ns, frame.truth);
  return frame;
}

cv::Mat Simulation::ThirdPersonView(int width_px, int height_px) {
  const Pose X_WB = world_.X_WB();
  const Pose X_WC = CameraPose(*world_.data(), FindCamera(world_.model(), rig_.WorldCameras().front().name));
  const double height = std::max(0.1, X_WC.translation.z());  // a robot is about as tall as its camera is high
  const Eigen::Vector3d middle(X_WB.translation.x(), X_WB.translation.y(), 0.55 * height);
  // From ahead on the robot's left, a little above: face, arms and the step are all seen.
  const Pose X_WV = LookAt(middle, 2.2 * height, X_WB.Yaw() + 2.3, -0.25);
  return renderer_.Picture(*world_.data(), X_WV, CameraModel::FromHorizontalFov(width_px, height_px, 55), 4);
}

}  // namespace gaitcam
