#include "sim/simulation.h"

#include <numbers>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "models/code/scenes/scene_crowd.h"
#include "sim/walking/walker.h"

namespace gaitcam {
namespace {

/// @param scene_start x m, y m, yaw rad. @param start x m, y m, yaw deg.
Pose StartPose(const Eigen::Vector3d& scene_start, const std::optional<Eigen::Vector3d>& start) {
  const double yaw = start ? start->z() * std::numbers::pi / 180 : scene_start.z();
  const Eigen::Vector3d& p = start ? *start : scene_start;
  return {RotZ(yaw), Eigen::Vector3d(p.x(), p.y(), 0)};
}

std::unique_ptr<Controller> MakeController(const Robot& robot, const mjModel* nominal, const SimulationOptions& options,
                                           const Pose& start, uint64_t seed) {
  if (robot.kind == Robot::Kind::kOmniBase) return MakeOmniDrive(robot, options.drive, options.path, start, seed);
  return MakeWalker(robot, nominal, options.gait, options.path, options.physics, start);
}

Pose PoseFrom(const double* position, const double* matrix) {
  const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix);
  return {R, Eigen::Vector3d(position[0], position[1], position[2])};
}

/// By the nominal kinematics, soles on the floor.
Pose StandingCameraPose(const Robot& robot, const Pose& X_MC, const Pose& X_WR, const std::vector<double>& joints) {
  return X_WR * LinkPoses(robot, joints)[robot.camera.link] * robot.camera.X_LS * X_MC;
}

std::optional<LegOdometry> LegsOf(const Robot& robot, const SensorOptions& options) {
  if (!options.odometry || robot.kind != Robot::Kind::kHumanoid) return std::nullopt;
  return LegOdometry(robot, options.odometry->rate_hz);
}

double PathTime(const Robot& robot, const SimulationOptions& options) {
  return robot.kind == Robot::Kind::kOmniBase ? EstimateDrivingTime(options.drive, options.path)
                                              : EstimateWalkingTime(options.gait, options.path);
}

/// The straight line that fits best, at `stamp_ns`: it averages the encoders' noise, and goes on where readings end.
class LineFit {
 public:
  explicit LineFit(int64_t stamp_ns) : stamp_ns_(stamp_ns) {}
  void Add(int64_t stamp_ns, double y) {
    const double x = 1e-9 * double(stamp_ns - stamp_ns_);
    n_ += 1, x_ += x, y_ += y, xx_ += x * x, xy_ += x * y;
  }
  double Value() const {
    GAITCAM_ASSERT(n_ > 0);
    const double spread = n_ * xx_ - x_ * x_;
    return spread > 0 ? (xx_ * y_ - x_ * xy_) / spread : y_ / n_;
  }

 private:
  int64_t stamp_ns_;
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

void CheckFinite(const char* what, const Eigen::Vector3d& numbers) {
  if (!numbers.allFinite())
    throw BadInput(std::string("the system commanded a ") + what + " that is not finite; expected three numbers");
}

/// The world's clock begins at 0, the sensors' at kClockStart_ns.
void ToSensorClock(SimulatedFrame& frame) {
  const auto shift = [](int64_t& stamp_ns) { stamp_ns += kClockStart_ns; };
  Observation& seen = frame.observation;
  shift(seen.stamp_ns);
  shift(seen.image.stamp_ns);
  if (seen.right) shift(seen.right->stamp_ns);
  if (seen.depth) shift(seen.depth->stamp_ns);
  for (ImuSample& sample : seen.imu) shift(sample.stamp_ns);
  for (JointSample& sample : seen.joints) shift(sample.stamp_ns);
  for (OdometrySample& sample : seen.odometry) shift(sample.stamp_ns);
  shift(frame.truth.stamp_ns);
  for (Subframe& subframe : frame.truth.subframes) shift(subframe.stamp_ns);
}

constexpr int64_t kPanFit_ns = 12'000'000;  ///< Readings so near to mid-exposure tell the pan.

}  // namespace

void CheckHeadScan(const Robot& robot, const SimulationOptions& options) {
  const CameraModel camera = CameraRig(options.camera, 0).MakeCalibration().camera;
  const HeadScanPlan plan = PlanHeadScan(robot, options.scan, camera, 1e-3 * options.camera.LongestExposure_ms());
  if (plan.sweeps == 1 || robot.kind != Robot::Kind::kHumanoid) return;
  const World world(robot, Scene{}, options.physics, {}, 0);
  PathOptions turning;
  turning.kind = PathKind::kThereAndBack;
  CheckGait(robot, world.nominal_model(), options.gait, turning, options.physics);
}

void CheckSimulation(const Robot& robot, const Scene& scene, const SimulationOptions& options, uint64_t seed) {
  options.camera.Check();
  Scene floor;  // the robot is asked, not the scene: an empty floor compiles in no time
  floor.start = scene.start;
  const World world(robot, floor, options.physics, {}, seed);
  MakeController(robot, world.nominal_model(), options, StartPose(scene.start, options.start), seed);
  SensorSuite(world, options.sensors, seed);
}

Simulation::Simulation(const Robot& robot, const Scene& scene, const SimulationOptions& options, uint64_t seed)
    : options_(options),
      gl_(options.camera.renderer),
      rig_(options.camera, seed, scene.light),
      world_(robot, scene, options.physics, rig_.WorldCameras(), seed),
      controller_(MakeController(robot, world_.nominal_model(), options, StartPose(scene.start, options.start), seed)),
      sensors_(world_, options.sensors, seed),
      renderer_(world_.model(), rig_.MakeRendererOptions(), world_.pictures()),
      calibration_(rig_.MakeCalibration()),
      middle_(MakePoseData(world_.model())),
      head_pan_(robot) {
  if (robot.kind == Robot::Kind::kHumanoid) {
    world_.ScaleServos(options.gait.servo_stiffness, options.gait.neck_stiffness);
  }
  PutAtStart();
  const Pose X_MC = rig_.WorldCameras().front().X_MC;
  calibration_.imu = CalibrateImu(robot, options.sensors, X_MC, controller_->InitialJoints());
  const Pose X_WR = controller_->InitialRoot();
  const Pose X_WC = StandingCameraPose(robot, X_MC, X_WR, controller_->InitialJoints());
  calibration_.standing = {X_WC.translation.z(), X_WC.R().transpose() * Eigen::Vector3d::UnitZ()};
  legs_ = LegsOf(robot, options.sensors);
  if (options.crowd) crowd_.emplace(*options.crowd, RoomOf(scene));
  calibration_.odometry =
      legs_ ? LegDataSheet(options.sensors.odometry->rate_hz) : CalibrateWheels(robot, options.sensors);
  if (calibration_.odometry.rate_hz > 0) calibration_.odometry.X_BC = PlanarPose(X_WR).Lifted().Inverse() * X_WC;
}

Simulation::~Simulation() = default;

void Simulation::PutAtStart() {
  world_.SetState(controller_->InitialRoot(), controller_->InitialJoints());
  last_position_ = world_.X_WB().translation.head<2>();
}

void Simulation::Restart(const Eigen::Vector3d& start, uint64_t seed) {
  options_.start = start;
  const Robot& robot = world_.robot();
  controller_ =
      MakeController(robot, world_.nominal_model(), options_, StartPose(Eigen::Vector3d::Zero(), start), seed);
  PutAtStart();
  rig_.Reseed(seed);
  sensors_ = SensorSuite(world_, options_.sensors, seed);
  legs_ = LegsOf(robot, options_.sensors);
  GAITCAM_ASSERT(!crowd_);  // it would be late
  frame_ = 0;
  status_ = SimulationStatus::kWalking;
  left_path_ = false;
  end_time_s_ = distance_m_ = scan_time_s_ = 0;
  joints_.clear();
  pans_.clear();
  lifted_at_.reset();
}

void Simulation::Command(const BodyCommand& command) {
  if (std::holds_alternative<Scan>(command)) {
    RequestScan();
    return;
  }
  if (std::holds_alternative<EndWalk>(command)) {
    if (status_ == SimulationStatus::kWalking) End(SimulationStatus::kFinished);
    return;
  }
  if (const Velocity* v = std::get_if<Velocity>(&command)) {
    CheckFinite("velocity", {v->forward_mps, v->left_mps, v->turn_rad_s});
  } else if (const GoTo* to = std::get_if<GoTo>(&command)) {
    CheckFinite("goal", {to->x_m, to->y_m, to->heading_rad});
  }
  if (!left_path_ && !std::holds_alternative<FollowPath>(command)) {
    CheckLeavingPath();
    left_path_ = true;
  }
  controller_->Command(command);
}

void Simulation::CheckLeavingPath() const {
  if (options_.duration_s <= 0 && options_.path.kind != PathKind::kStand) {
    throw BadInput(
        "duration_s: 0 means until the path ends, which a system that leaves the path need not reach; expected a time");
  }
  if (world_.robot().kind != Robot::Kind::kHumanoid) return;
  PathOptions turning;
  turning.kind = PathKind::kThereAndBack;
  CheckGait(world_.robot(), world_.nominal_model(), options_.gait, turning, options_.physics);
}

void Simulation::RequestScan() {
  if (controller_->Scans()) return;
  const double exposure_s = 1e-3 * options_.camera.LongestExposure_ms();
  controller_->RequestScan(PlanHeadScan(world_.robot(), options_.scan, calibration_.camera, exposure_s));
}

int64_t Simulation::ExpectedFrames() const {
  if (path_time_s_ < 0) path_time_s_ = PathTime(world_.robot(), options_);
  double time_s = path_time_s_ + scan_time_s_;
  if (options_.duration_s > 0) time_s = std::min(options_.duration_s, time_s);
  return int64_t(time_s * options_.camera.rate_hz);
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
  if (options_.path.feedback == PathFeedback::kTruth) input.X_WB = world_.X_WB();
  Carry();
  world_.SetTargets(controller_->Update(input));
  if (controller_->Scans()) scan_time_s_ += 1e-9 * double(world_.control_period_ns());
  pans_.push_back({input.stamp_ns, head_pan_.Of(input.joints.position), controller_->SweepTurn()});
  const Eigen::Vector2d position = world_.X_WB().translation.head<2>();
  if (!lifted_at_) distance_m_ += (position - last_position_).norm();
  last_position_ = position;
  MoveCrowd();
}

/// Off the floor, if it is lifted now.
void Simulation::Carry() {
  if (!options_.kidnap) return;
  const double time_s = 1e-9 * double(world_.stamp_ns());
  const bool carried = IsCarried(*options_.kidnap, time_s);
  if (carried && !lifted_at_) lifted_at_ = PlanarPose(world_.X_WB());
  if (lifted_at_) controller_->Hold(CarriedTo(*options_.kidnap, *lifted_at_, time_s));
  if (!carried) lifted_at_.reset();
}

void Simulation::MoveCrowd() {
  if (!crowd_ || !crowd_->Advance(1e-9 * double(world_.stamp_ns()), last_position_)) return;
  std::vector<PersonWalk> people = *world_.people();
  crowd_->Replan(std::span(people).last(crowd_->size()));
  world_.SetPeople(std::make_shared<const std::vector<PersonWalk>>(std::move(people)));
}

/// @returns false if the run ended before `stamp_ns`.
bool Simulation::WalkUntil(int64_t stamp_ns) {
  while (world_.stamp_ns() < stamp_ns) {
    if (world_.stamp_ns() % world_.control_period_ns() == 0) Control();
    world_.Step();
    sensors_.Step(world_, !lifted_at_);
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

/// Of an exposure that lies in a sweep from its first control period to its last.
std::optional<ScanState> Simulation::ScanAt(int64_t stamp_ns) const {
  const int64_t open_ns = rig_.Shutter(stamp_ns).open_ns;
  LineFit pan(stamp_ns);
  std::optional<double> turn;
  for (const PanSample& sample : pans_) {
    if (std::abs(sample.stamp_ns - stamp_ns) <= kPanFit_ns) pan.Add(sample.stamp_ns, sample.pan_rad);
    if (sample.stamp_ns + world_.control_period_ns() <= open_ns) continue;
    if (!sample.sweep_turn_rad) return std::nullopt;
    turn = sample.sweep_turn_rad;
  }
  if (!turn) return std::nullopt;
  return ScanState{pan.Value(), *turn};
}

/// To the end of the next frame's exposure. @returns false if the run is over.
bool Simulation::WalkToNextFrame() {
  if (status_ != SimulationStatus::kWalking) return false;
  const ShutterInterval shutter = rig_.Shutter(rig_.FrameStamp(frame_));
  while (!pans_.empty() && pans_.front().stamp_ns < shutter.open_ns - kPanFit_ns) pans_.pop_front();
  if (!WalkUntil(shutter.close_ns)) return false;
  world_.record().DropBefore(shutter.open_ns);
  return true;
}

/// All since the last frame.
void Simulation::TakeReadings(Observation& seen) {
  seen.imu = sensors_.TakeImu();
  seen.joints = std::exchange(joints_, {});
  seen.odometry = legs_ ? legs_->Update(seen.imu, seen.joints) : sensors_.TakeOdometry();
}

LatentSimulatedFrame Simulation::Film(const TruthOptions& truth) {
  const int64_t stamp_ns = rig_.FrameStamp(frame_);
  const std::optional<ScanState> scan = ScanAt(stamp_ns);
  LatentSimulatedFrame latent{{}, rig_.Film(renderer_, world_.record(), frame_++, truth)};
  Observation& seen = latent.observation;
  seen.stamp_ns = stamp_ns;
  seen.exposure_ms = latent.film.exposure_ms;
  TakeReadings(seen);
  seen.scan = scan;
  FillTruth(stamp_ns, latent.film.left.frame.truth);
  return latent;
}

SimulatedFrame Simulation::Develop(LatentSimulatedFrame latent) const {
  RigFrame exposed = rig_.Develop(std::move(latent.film));
  SimulatedFrame frame{std::move(latent.observation), std::move(exposed.left.truth)};
  frame.observation.image = std::move(exposed.left.image);
  if (exposed.right) frame.observation.right = std::move(exposed.right->image);
  frame.observation.depth = std::move(exposed.depth);
  ToSensorClock(frame);
  return frame;
}

void Simulation::SkipFrame() {
  ++frame_;
  Observation unseen;
  TakeReadings(unseen);
}

std::optional<LatentSimulatedFrame> Simulation::NextLatent(const TruthOptions& truth) {
  if (!WalkToNextFrame()) return std::nullopt;
  return Film(truth);
}

std::optional<SimulatedFrame> Simulation::Next(const TruthOptions& truth) {
  std::optional<LatentSimulatedFrame> latent = NextLatent(truth);
  if (!latent) return std::nullopt;
  return Develop(std::move(*latent));
}

std::optional<SimulatedFrame> Simulation::NextFrom(double time_s, const TruthOptions& truth) {
  while (WalkToNextFrame()) {
    if (1e-9 * double(world_.stamp_ns()) >= time_s) return Develop(Film(truth));
    SkipFrame();
  }
  return std::nullopt;
}

std::optional<SimulatedFrame> Simulation::NextOfScan(const TruthOptions& truth) {
  while (controller_->Scans() && WalkToNextFrame()) {
    if (ScanAt(rig_.FrameStamp(frame_))) return Develop(Film(truth));
    SkipFrame();
  }
  return std::nullopt;
}

cv::Mat Simulation::ThirdPersonView(int width_px, int height_px) {
  const Pose X_WB = world_.X_WB();
  const Pose X_WC = CameraPose(*world_.data(), FindCamera(world_.model(), rig_.WorldCameras().front().name));
  const double height = std::max(0.1, X_WC.translation.z());  // a robot is about as tall as its camera is high
  const Eigen::Vector3d middle(X_WB.translation.x(), X_WB.translation.y(), 0.55 * height);
  // From ahead on the robot's left, a little above: face, arms and the step are all seen.
  const Pose X_WV = LookAt(middle, 2.2 * height, X_WB.Yaw() + 2.3, -0.25);
  return renderer_.Picture(*world_.data(), X_WV, CameraModel::FromHorizontalFov(width_px, height_px, 55), 2);
}

}  // namespace gaitcam
