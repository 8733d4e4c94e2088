/// A robot in a scene, as a MuJoCo model that runs.

#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "models/code/people/person_walk.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"

namespace gaitcam {

struct MjModelDeleter {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
};
struct MjDataDeleter {
  void operator()(mjData* d) const { mj_deleteData(d); }
};
using MjModelPtr = std::unique_ptr<mjModel, MjModelDeleter>;
using MjDataPtr = std::unique_ptr<mjData, MjDataDeleter>;

struct PhysicsOptions {
  using DescribedTag = void;
  double timestep_ms = 2.0;
  double control_period_ms = 4.0;
  double mass_noise_ratio = 0.0;
  double friction_noise_ratio = 0.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, PhysicsOptions& o) {
  visit("timestep_ms", o.timestep_ms, Between(0.1, 5.0), "MuJoCo's step; the control period is a whole multiple of it");
  visit("control_period_ms", o.control_period_ms, Between(0.1, 20.0), "a whole multiple of the step");
  visit("mass_noise_ratio", o.mass_noise_ratio, Between(0.0, 0.5),
        "each link's mass and inertia times 1 + uniform(-r, r), by seed");
  visit("friction_noise_ratio", o.friction_noise_ratio, Between(0.0, 0.9),
        "floor friction times 1 + uniform(-r, r), by seed");
}

/// The state of the mechanism at one physics step.
struct PhysicsState {
  int64_t stamp_ns = 0;
  std::vector<double> qpos, qvel;
};

/// The mechanism's exact motion between physics steps. MuJoCo's semi-implicit Euler step moves the configuration with
/// the constant velocity of the step's end, so q(t) = q_k + (t - t_k) v_{k+1} (on the manifold) is the integrator's own
/// interpolation.
class MotionRecord {
 public:
  /// @pre the stamp is later than the last one's.
  void Append(PhysicsState state);
  /// Drops the states that are not needed to evaluate instants from `stamp_ns` on. Called regularly, it bounds memory.
  void DropBefore(int64_t stamp_ns);
  void Clear() { states_.clear(); }
  bool empty() const { return states_.empty(); }
  int64_t first_stamp_ns() const { return states_.front().stamp_ns; }
  int64_t last_stamp_ns() const { return states_.back().stamp_ns; }
  /// People's poses are functions of time (PersonWalk), so they are evaluated and not recorded.
  /// @pre the model that `Evaluate` is given has their bodies, in this order.
  void SetPeople(std::shared_ptr<const std::vector<PersonWalk>> people) { people_ = std::move(people); }
  /// Puts `data` into the configuration at `stamp_ns`, people included, and updates kinematics, cameras and lights.
  /// @pre the stamp lies within the record.
  void Evaluate(const mjModel* model, int64_t stamp_ns, mjData* data) const;
  /// The same, but people's bodies stay where they are in `data`: a crowd takes far longer than a robot.
  void EvaluateRobot(const mjModel* model, int64_t stamp_ns, mjData* data) const;
  /// Null if none were set.
  const std::vector<PersonWalk>* people() const { return people_.get(); }

 private:
  void PutRobot(const mjModel* model, int64_t stamp_ns, mjData* data) const;

  std::deque<PhysicsState> states_;
  std::shared_ptr<const std::vector<PersonWalk>> people_;
};

/// The bodies from this number on are people's parts: kPersonParts of each person, in the order of PersonPart.
inline int FirstPersonBody(const mjModel* model) { return model->nbody - model->nmocap; }

/// Puts people where they are at an instant; their bodies move with the next kinematics.
void PosePeople(const mjModel* model, const std::vector<PersonWalk>& people, int64_t stamp_ns, mjData* data);

/// What a texture of a model shows. Physics needs no pictures and drawing needs them once, to hand them to OpenGL: a
/// compiled model has a single pixel in the place of each.
struct TexturePicture {
  std::string texture;
  std::function<cv::Mat()> make;  ///< CV_8UC3 (BGR), row 0 on top.
};

/// What a model's geom may carry as user data: a solid core that lies within its shape, in the frame of its body, m.
/// It spans two elliptical discs, each written as its centre and two half axes. Nothing, or zeros: there is none.
constexpr int kCoreNumbers = 18;

/// MJCF of a robot in a scene, with the meshes that it refers to, and the pictures of its textures.
struct MjcfBundle {
  std::string xml;
  std::vector<std::pair<std::string, std::vector<unsigned char>>> files;  ///< Lower-case names without folders.
  std::vector<TexturePicture> pictures;
};

/// One camera to be put on the robot: extrinsics relative to the robot's camera mount.
struct WorldCamera {
  std::string name;
  Pose X_MC;  ///< Maps points of this camera (optical frame) into the mount's optical frame.
};

/// Names in the model: bodies and joints as in the URDF, `servo_JOINT`, `floor`, `box0`, `box1`, ..., the cameras' own,
/// the site `imu` with sensors `gyro` and `accelerometer`; `person0.hips`, `person0.left_shoe`, ... (PersonPartName).
/// An omni base has joints and actuators `drive_x`, `drive_y`, `drive_yaw`, `drive_pitch` and `drive_roll` between
/// world and root. Visible shapes are in geom groups 0 (scene) and 1 (robot); shapes that only collide in group 3,
/// which is not drawn by default. The robot collides with the scene, not with itself nor with people. Floor and boxes
/// decide the friction of contacts.
/// @throws BadInput if the scene has more textures than MuJoCo can draw, or a mesh file cannot be read.
MjcfBundle BuildMjcf(const Robot& robot, const Scene& scene, const PhysicsOptions& physics,
                     const std::vector<WorldCamera>& cameras);

/// Without the pictures. @throws BadInput if MuJoCo refuses the model, with its own words.
MjModelPtr CompileMjcf(const MjcfBundle& bundle, const std::string& name);

/// State for kinematics alone: positions, the centre of mass, cameras, lights, gravity's forces. Without the room for
/// contacts, which in mj_makeData's is nearly all of it.
MjDataPtr MakePoseData(const mjModel* model);

/// Physics, and what is true of it.
///
/// After each step, positions, contacts, cameras and the gyro in `data()` belong to `stamp_ns()`; accelerations and
/// contact forces belong to the step that ended there.
class World {
 public:
  /// @throws BadInput if MuJoCo refuses the model, with its own words; BadOption if the control period is not a whole
  /// multiple of the time step.
  World(const Robot& robot, const Scene& scene, const PhysicsOptions& physics, const std::vector<WorldCamera>& cameras,
        uint64_t seed);

  const mjModel* model() const { return model_.get(); }
  /// The unperturbed model: what a controller may know of the robot.
  const mjModel* nominal_model() const { return nominal_.get(); }
  /// Of the model's textures, for a Renderer.
  const std::vector<TexturePicture>& pictures() const { return pictures_; }
  mjData* data() { return data_.get(); }
  const mjData* data() const { return data_.get(); }

  int64_t stamp_ns() const { return step_count_ * timestep_ns_; }
  int64_t timestep_ns() const { return timestep_ns_; }
  int64_t control_period_ns() const { return control_period_ns_; }

  /// Multiplies gains (kp and kv) of the leg servos and of the neck servos; factors are relative to the robot file.
  void ScaleServos(double legs, double neck);
  /// Puts the robot's root at a pose with its joints at given positions (order of Robot::joints, fixed ones included),
  /// at rest, at time 0, and the servos' targets likewise. Of an omni base, only x, y and yaw of the pose count.
  void SetState(const Pose& X_WB, const std::vector<double>& joint_positions);
  /// How many targets SetTargets expects: one per joint of Robot::joints, and for an omni base five more.
  size_t target_count() const { return actuator_.size(); }
  /// Servo targets, in the order of Robot::joints (fixed ones ignored); for an omni base, followed by x, y (m) and yaw
  /// (rad, not wrapped) of the base in the world.
  void SetTargets(const std::vector<double>& targets);
  /// One physics step; the new state is appended to the record.
  /// @throws std::runtime_error with MuJoCo's message if it warned (an unstable state).
  void Step();

  Pose X_WB() const;                                                  ///< True pose of the root link.
  std::vector<double> JointPositions() const;                         ///< True, order of Robot::joints (0 for fixed).
  bool FootContact(int side) const { return foot_force_[side] > 0; }  ///< 0 left, 1 right: touches anything.
  double FootForce(int side) const { return foot_force_[side]; }  ///< Normal contact force, N, during the last step.
  /// Root link too low or tilted by more than 53 degrees, or a link other than the feet on the floor.
  bool HasFallen() const;
  /// Never null.
  const std::shared_ptr<const std::vector<PersonWalk>>& people() const { return people_; }
  /// The same people, who have changed their minds. @pre up to now they have walked as the former ones.
  void SetPeople(std::shared_ptr<const std::vector<PersonWalk>> people);
  MotionRecord& record() { return record_; }
  const MotionRecord& record() const { return record_; }
  const Robot& robot() const { return robot_; }

 private:
  void Perturb(const PhysicsOptions& physics, uint64_t seed);
  void FindAddresses();
  void ReadContacts();
  void AppendRecord();
  void ThrowOnWarning() const;

  Robot robot_;
  MjModelPtr model_, nominal_;
  std::vector<TexturePicture> pictures_;
  MjDataPtr data_;
  int64_t timestep_ns_ = 0, control_period_ns_ = 0, step_count_ = 0;
  double standing_height_ = 0;
  MotionRecord record_;
  std::shared_ptr<const std::vector<PersonWalk>> people_;
  std::vector<int> qpos_address_;  ///< Per joint of Robot::joints, -1 where there is none.
  std::vector<int> actuator_;      ///< Per target, -1 where there is none.
  std::array<int, 2> foot_body_{-1, -1};
  std::array<double, 2> foot_force_{0, 0};
  int root_body_ = -1, floor_geom_ = -1;
  bool body_on_floor_ = false;
};

}  // namespace gaitcam
