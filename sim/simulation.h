/// A robot walks through a scene and its sensors see it: physics, control, cameras and sensors on one clock.

#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "algorithms/core/observation.h"
#include "models/code/people/crowd.h"
#include "sim/camera/camera_rig.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/renderer.h"
#include "sim/sensors/sensors.h"
#include "sim/walking/controller.h"
#include "sim/walking/kidnap.h"
#include "sim/walking/leg_odometry.h"
#include "sim/walking/omni_drive.h"
#include "sim/walking/path.h"
#include "sim/world/world.h"

namespace gaitcam {

struct SimulationOptions {
  GaitOptions gait;
  PathOptions path;
  PhysicsOptions physics;
  OmniDriveOptions drive;
  CameraOptions camera;
  SensorOptions sensors;
  HeadScanOptions scan;                  ///< How it looks all around when asked to.
  double duration_s = 0;                 ///< 0: until the path ends.
  std::optional<Eigen::Vector3d> start;  ///< x m, y m, yaw deg; the scene's own if absent.
  std::optional<KidnapOptions> kidnap;   ///< Of a wheeled base.
  std::optional<CrowdPlan> crowd;  ///< Of the last of the scene's people, who then mind where the robot really is.
};

/// All stamps are of the sensors' clock, which shows kClockStart_ns (algorithms/core/clock.h) when the walk begins.
struct SimulatedFrame {
  Observation observation;
  FilmedTruth truth;  ///< Never shown to an estimator.
};

/// A frame that was filmed and not developed yet. It holds all that Simulation::Develop needs.
struct LatentSimulatedFrame {
  Observation observation;  ///< All but images and depth; stamps of the world's clock.
  LatentRigFrame film;
};

enum class SimulationStatus {
  kWalking,
  kFinished,  ///< The path or the time ended with the robot on its feet.
  kFell,
};

/// Not thread-safe: create, use and destroy on one thread (the GL context belongs to it).
class Simulation {
 public:
  /// @throws BadInput if the robot cannot do what the gait or path asks; MissingResource if there is no EGL device.
  Simulation(const Robot& robot, const Scene& scene, const SimulationOptions& options, uint64_t seed);
  ~Simulation();

  /// What a calibration of the rig would tell a SLAM system.
  const Calibration& calibration() const { return calibration_; }
  const EglContext& gl() const { return gl_; }

  /// Walks on to the end of the next exposure. @param truth which costly parts of the truth are wanted.
  /// @returns nothing when the run is over: see status().
  std::optional<SimulatedFrame> Next(const TruthOptions& truth = {});

  /// The same, but only films: develops nothing, which takes no renderer and no world.
  std::optional<LatentSimulatedFrame> NextLatent(const TruthOptions& truth = {});
  /// May run on another thread while the walk goes on.
  SimulatedFrame Develop(LatentSimulatedFrame latent) const;

  /// Walks on without filming to the first frame whose exposure ends at `time_s` or later, and films that.
  std::optional<SimulatedFrame> NextFrom(double time_s, const TruthOptions& truth = {});
  /// Walks on to the next frame of the present scan's sweeps; what lies between is not filmed.
  /// @returns nothing when the scan, or the run, is over.
  std::optional<SimulatedFrame> NextOfScan(const TruthOptions& truth = {});

  /// What a system asks of the body; holds until another command comes.
  /// @throws BadInput naming what the robot cannot do: a scan out of its head's reach, a gait whose feet touch in
  /// turns, numbers that are not finite, a run without a duration that leaves its path.
  void Command(const BodyCommand& command);

  /// Asks the robot to stop, to look all around, and to go on; meanwhile, asking again changes nothing. What it sees in
  /// its sweeps has Observation::scan.
  /// @throws BadOption if its head does not reach far enough: see CheckHeadScan.
  void RequestScan();
  /// It was asked to and has not gone on yet.
  bool scans() const { return controller_->Scans(); }

  /// Puts the robot elsewhere, at rest and at time 0, as if it had been created there: scene, model and renderer are
  /// those that are there already. @param start x m, y m, yaw deg. @param seed of cameras and sensors; what the first
  /// seed made of masses and friction stays.
  void Restart(const Eigen::Vector3d& start, uint64_t seed);

  SimulationStatus status() const { return status_; }
  /// Seconds from the start at which the robot fell, or the run ended.
  double end_time_s() const { return end_time_s_; }
  /// Frames expected until the time or the path ends; an estimate where the path's time is not known.
  int64_t ExpectedFrames() const;
  /// True length of the path walked so far by the robot's root, m.
  double distance_m() const { return distance_m_; }

  /// What the last frame was filmed of and with: to measure other cameras in the same place. Call between frames.
  World& world() { return world_; }
  Renderer& renderer() { return renderer_; }
  /// Number of the frame that the next call films.
  int64_t next_frame() const { return frame_; }

  /// A picture of the robot from beside it, BGR. Call between frames.
  cv::Mat ThirdPersonView(int width_px, int height_px);

 private:
  void CheckLeavingPath() const;
  bool WalkUntil(int64_t stamp_ns);
  bool WalkToNextFrame();
  LatentSimulatedFrame Film(const TruthOptions& truth);
  void TakeReadings(Observation& seen);
  void SkipFrame();
  void PutAtStart();
  void MoveCrowd();
  void Carry();
  void Control();
  std::optional<ScanState> ScanAt(int64_t stamp_ns) const;
  void FillTruth(int64_t stamp_ns, FrameTruth& truth);
  void End(SimulationStatus status);

  /// Where the head looked at one control period, by its encoders, and whether it swept.
  struct PanSample {
    int64_t stamp_ns;
    double pan_rad;
    std::optional<double> sweep_turn_rad;
  };

  SimulationOptions options_;
  EglContext gl_;
  CameraRig rig_;
  World world_;
  std::unique_ptr<Controller> controller_;
  SensorSuite sensors_;
  std::optional<LegOdometry> legs_;
  std::optional<LiveCrowd> crowd_;
  std::optional<PlanarPose> lifted_at_;  ///< While it is carried.
  Renderer renderer_;
  Calibration calibration_;
  MjDataPtr middle_;  ///< The mechanism at mid-exposure.
  int64_t frame_ = 0;
  SimulationStatus status_ = SimulationStatus::kWalking;
  double end_time_s_ = 0, distance_m_ = 0;
  Eigen::Vector2d last_position_;
  std::vector<JointSample> joints_;  ///< Since the last frame, one per control period.
  bool left_path_ = false;           ///< It was commanded once to do anything but to follow the path or scan.
  HeadPan head_pan_;
  std::deque<PanSample> pans_;       ///< Of the last exposure and a little more.
  mutable double path_time_s_ = -1;  ///< Once it was asked for.
  double scan_time_s_ = 0;           ///< Spent in scans so far.
};

/// Whether a robot can look all around when asked to. @throws BadOption: see PlanHeadScan, and CheckGait for the turn
/// on the spot that it may take.
void CheckHeadScan(const Robot& robot, const SimulationOptions& options);

/// Whether a robot can do what the options ask, without running it: the model compiles, the gait is within reach.
/// @throws BadInput or BadOption naming the limit.
void CheckSimulation(const Robot& robot, const Scene& scene, const SimulationOptions& options, uint64_t seed);

}  // namespace gaitcam
