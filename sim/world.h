/// A robot in a place, as a MuJoCo model that runs.

#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "models/place.h"
#include "models/robot.h"

namespace gaitcam {

struct MjModelDeleter { void operator()(mjModel* m) const { mj_deleteModel(m); } };
struct MjDataDeleter { void operator()(mjData* d) const { mj_deleteData(d); } };
using MjModelPtr = std::unique_ptr<mjModel, MjModelDeleter>;
using MjDataPtr = std::unique_ptr<mjData, MjDataDeleter>;

struct PhysicsOptions {
  using DescribedTag = void;
  double timestep_ms = 2.0;              ///< MuJoCo's step; the control period is a whole multiple of it.
  double control_period_ms = 4.0;
  double mass_noise_ratio = 0.0;         ///< Each link's mass and inertia times 1 + uniform(-r, r), by seed.
  double friction_noise_ratio = 0.0;     ///< Floor friction times 1 + uniform(-r, r), by seed.
};

template <class Visitor>
void VisitFields(Visitor& visit, PhysicsOptions& o) {
  visit("timestep_ms", o.timestep_ms, Between(0.1, 5.0), "MuJoCo's step");
  visit("control_period_ms", o.control_period_ms, Between(0.1, 20.0), "a whole multiple of the step");
  visit("mass_noise_ratio", o.mass_noise_ratio, Between(0.0, 0.5), "each link's mass is off by up to this part");
  visit("friction_noise_ratio", o.friction_noise_ratio, Between(0.0, 0.9), "the floor's friction is off by up to this part");
}

/// The state of the mechanism at one physics step.
struct PhysicsState {
  int64_t stamp_ns = 0;
  std::vector<double> qpos, qvel;
};

/// The mechanism's exact path between physics steps. MuJoCo's semi-implicit Euler step moves the configuration with the
/// constant velocity of the step's end, so q(t) = q_k + (t - t_k) v_{k+1} (on the manifold) is the integrator's own path.
class MotionRecord {
 public:
  void Append(PhysicsState state);
  void DropBefore(int64_t stamp_ns);
  int64_t first_stamp_ns() const { return states_.front().stamp_ns; }
  int64_t last_stamp_ns() const { return states_.back().stamp_ns; }
  /// Puts `data` into the configuration at `stamp_ns` and updates kinematics, cameras and lights.
  /// @pre the stamp lies within the record.
  void Evaluate(const mjModel* model, int64_t stamp_ns, mjData* data) const;

 private:
  std::deque<PhysicsState> states_;
};

/// MJCF of a robot in a place, and the pictures and meshes that it names.
struct MjcfBundle {
  std::string xml;
  std::vector<std::pair<std::string, std::vector<unsigned char>>> files;  ///< Lower-case names without folders.
};

/// One camera to be put on the robot: extrinsics relative to the robot's camera mount.
struct WorldCamera {
  std::string name;
  Pose X_MC;               ///< Maps points of this camera (optical frame) into the mount's optical frame.
};

MjcfBundle BuildMjcf(const Robot& robot, const Place& place, const PhysicsOptions& physics,
                     const std::vector<WorldCamera>& cameras);

/// Physics, and what is true of it.
class World {
 public:
  /// @throws BadInput if MuJoCo refuses the model, with its own words.
  World(const Robot& robot, const Place& place, const PhysicsOptions& physics, const std::vector<WorldCamera>& cameras,
        uint64_t seed);

  const mjModel* model() const { return model_.get(); }
  /// The unperturbed model: what a controller may know of the robot.
  const mjModel* nominal_model() const { return nominal_.get(); }
  mjData* data() { return data_.get(); }
  const mjData* data() const { return data_.get(); }

  int64_t stamp_ns() const { return step_count_ * timestep_ns_; }
  int64_t timestep_ns() const { return timestep_ns_; }

  /// Puts the robot's root at a pose with its joints at given positions (order of Robot::joints, fixed ones included).
  void Place(const Pose& X_WB, const std::vector<double>& joint_positions);
  /// Servo targets, in the order of Robot::joints (fixed ones ignored); an omni base's wheels or planar joints likewise.
  void SetTargets(const std::vector<double>& targets);
  /// One physics step; the new state is appended to the record.
  /// @throws std::runtime_error with MuJoCo's words if it warned (a bad state): never silently.
  void Step();

  Pose X_WB() const;                             ///< True pose of the root link.
  std::vector<double> JointPositions() const;    ///< True, order of Robot::joints (0 for fixed).
  bool FootContact(int side) const;              ///< 0 left, 1 right: any contact force between foot and anything else.
  bool HasFallen() const;                        ///< Root link too low or tilted by more than 53 degrees, or a non-foot link on the floor.
  MotionRecord& record() { return record_; }
  const Robot& robot() const { return robot_; }

 private:
  Robot robot_;
  MjModelPtr model_, nominal_;
  MjDataPtr data_;
  int64_t timestep_ns_ = 0, step_count_ = 0;
  double standing_height_ = 0;
  MotionRecord record_;
  std::vector<int> qpos_address_, actuator_;     ///< Per joint of Robot::joints, -1 where there is none.
  std::array<int, 2> foot_body_{-1, -1};
};

}  // namespace gaitcam
