#include "sim/world/world.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <mutex>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// MuJoCo reports through two process-wide function pointers. An error must not return, so it throws; a warning is
/// stored, and World::Step throws it.
thread_local std::string last_warning;

void InstallMujocoHandlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = [](const char* text) { throw std::runtime_error(std::string("MuJoCo: ") + text); };
    mju_user_warning = [](const char* text) { last_warning = text; };
  });
}

struct VfsDeleter {
  void operator()(mjVFS* vfs) const {
    mj_deleteVFS(vfs);
    delete vfs;
  }
};

void AddFile(mjVFS* vfs, const std::string& name, const void* bytes, size_t size) {
  GAITCAM_ASSERT(mj_makeEmptyFileVFS(vfs, name.c_str(), int(size)) == 0);
  std::memcpy(vfs->filedata[mj_findFileVFS(vfs, name.c_str())], bytes, size);
}

int Id(const mjModel* model, mjtObj kind, const std::string& name) {
  const int id = mj_name2id(model, kind, name.c_str());
  GAITCAM_ASSERT(id >= 0);
  return id;
}

/// Whether a shape belongs to the scene: to the world, or to a body that is fixed to it.
bool IsOfScene(const mjModel* model, int geom) { return model->body_weldid[model->geom_bodyid[geom]] == 0; }

}  // namespace

MjModelPtr CompileMjcf(const MjcfBundle& bundle, const std::string& name) {
  InstallMujocoHandlers();
  std::unique_ptr<mjVFS, VfsDeleter> vfs(new mjVFS);  // 2 MB: too large for the stack
  mj_defaultVFS(vfs.get());
  AddFile(vfs.get(), "model.xml", bundle.xml.data(), bundle.xml.size());
  for (const auto& [file, bytes] : bundle.files) AddFile(vfs.get(), file, bytes.data(), bytes.size());
  char error[1000] = "";
  MjModelPtr model(mj_loadXML("model.xml", vfs.get(), error, sizeof error));
  if (!model) {
    std::string words(error);
    std::replace(words.begin(), words.end(), '\n', ' ');
    throw BadInput(name + ": MuJoCo refuses the model: " + words);
  }
  return model;
}

MjDataPtr MakePoseData(const mjModel* model) {
  mjModel without_contacts = *model;  // MuJoCo reads the sizes; only this shallow copy changes
  without_contacts.njmax = without_contacts.nconmax = 0;
  return MjDataPtr(mj_makeData(&without_contacts));
}

World::World(const Robot& robot, const Scene& scene, const PhysicsOptions& physics,
             const std::vector<WorldCamera>& cameras, uint64_t seed)
    : robot_(robot) {
  CheckFields(physics, "physics.");
  timestep_ns_ = std::llround(physics.timestep_ms * 1e6);
  control_period_ns_ = std::llround(physics.control_period_ms * 1e6);
  if (control_period_ns_ % timestep_ns_ != 0) {
    throw BadOption(fmt::format("physics.control_period_ms = {}: expected a whole multiple of physics.timestep_ms = {}",
                                physics.control_period_ms, physics.timestep_ms));
  }
  MjcfBundle bundle = BuildMjcf(robot, scene, physics, cameras);
  nominal_ = CompileMjcf(bundle, robot.urdf_file.string());
  pictures_ = std::move(bundle.pictures);
  model_.reset(mj_copyModel(nullptr, nominal_.get()));
  data_.reset(mj_makeData(model_.get()));
  people_ = std::make_shared<const std::vector<PersonWalk>>(scene.people.begin(), scene.people.end());
  record_.SetPeople(people_);
  FindAddresses();
  Perturb(physics, seed);
  double height = robot_.base_height_m;
  if (robot_.kind == Robot::Kind::kHumanoid) {
    const Pose X_RF = LinkPoses(robot_, std::vector<double>(robot_.joints.size(), 0.0))[robot_.legs[0].foot_link];
    height = -(X_RF * robot_.legs[0].sole_center).z();
  }
  SetState(Pose(Eigen::Quaterniond::Identity(), {0, 0, height}), std::vector<double>(robot_.joints.size(), 0.0));
}

void World::FindAddresses() {
  const mjModel* m = model_.get();
  for (const RobotJoint& joint : robot_.joints) {
    const bool moves = joint.kind != RobotJoint::Kind::kFixed;
    qpos_address_.push_back(moves ? m->jnt_qposadr[Id(m, mjOBJ_JOINT, joint.name)] : -1);
    actuator_.push_back(moves ? Id(m, mjOBJ_ACTUATOR, "servo_" + joint.name) : -1);
  }
  if (robot_.kind == Robot::Kind::kOmniBase) {
    for (const char* name : {"drive_x", "drive_y", "drive_yaw", "drive_pitch", "drive_roll"})
      actuator_.push_back(Id(m, mjOBJ_ACTUATOR, name));
  } else {
    for (int side = 0; side < 2; ++side) {
      foot_body_[side] = Id(m, mjOBJ_BODY, robot_.links[robot_.legs[side].foot_link].name);
    }
  }
  root_body_ = Id(m, mjOBJ_BODY, robot_.links[0].name);
  floor_geom_ = Id(m, mjOBJ_GEOM, "floor");
}

void World::Perturb(const PhysicsOptions& physics, uint64_t seed) {
  mjModel* m = model_.get();
  RandomStream mass(seed, "mass"), friction(seed, "friction");
  for (const RobotLink& link : robot_.links) {
    const int body = Id(m, mjOBJ_BODY, link.name);
    const double factor = 1 + physics.mass_noise_ratio * mass.Uniform(-1, 1);
    m->body_mass[body] *= factor;
    for (int i = 0; i < 3; ++i) m->body_inertia[3 * body + i] *= factor;
  }
  const double factor = 1 + physics.friction_noise_ratio * friction.Uniform(-1, 1);
  for (int geom = 0; geom < m->ngeom; ++geom) {
    if (IsOfScene(m, geom)) m->geom_friction[3 * size_t(geom)] *= factor;
  }
  const mjStatistic scale = m->stat;
  mj_setConst(m, data_.get());
  // mj_setConst also recomputes the scene's extent, which scales clipping planes and shadows.
  m->stat.extent = scale.extent;
  std::copy(scale.center, scale.center + 3, m->stat.center);
}

void World::ScaleServos(double legs, double neck) {
  GAITCAM_ASSERT(legs > 0 && neck > 0);
  std::vector<double> factors(robot_.joints.size(), 1.0);
  if (robot_.kind == Robot::Kind::kHumanoid) {
    for (const RobotLeg& leg : robot_.legs) {
      for (int joint : leg.joints) factors[joint] = legs;
    }
  }
  for (int joint : {robot_.neck_pan, robot_.neck_tilt, robot_.camera_pan}) {
    if (joint >= 0) factors[joint] = neck;
  }
  for (size_t i = 0; i < factors.size(); ++i) {
    if (actuator_[i] < 0) continue;
    const int gain = mjNGAIN * actuator_[i], bias = mjNBIAS * actuator_[i];
    model_->actuator_gainprm[gain] = nominal_->actuator_gainprm[gain] * factors[i];
    for (int k = 1; k <= 2; ++k) model_->actuator_biasprm[bias + k] = nominal_->actuator_biasprm[bias + k] * factors[i];
  }
}

void World::SetState(const Pose& X_WB, const std::vector<double>& joint_positions) {
  GAITCAM_ASSERT(joint_positions.size() == robot_.joints.size());
  mjData* d = data_.get();
  mj_resetData(model_.get(), d);
  std::vector<double> targets = joint_positions;
  if (robot_.kind == Robot::Kind::kHumanoid) {
    const Eigen::Quaterniond& q = X_WB.rotation;
    const Eigen::Vector3d& p = X_WB.translation;
    const double free_joint[7] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy(free_joint, free_joint + 7, d->qpos);
  } else {
    const double drive[5] = {X_WB.translation.x(), X_WB.translation.y(), X_WB.Yaw(), 0, 0};
    std::copy(drive, drive + 5, d->qpos);
    targets.insert(targets.end(), drive, drive + 5);
  }
  for (size_t i = 0; i < joint_positions.size(); ++i) {
    if (qpos_address_[i] >= 0) d->qpos[qpos_address_[i]] = joint_positions[i];
  }
  standing_height_ = X_WB.translation.z();
  step_count_ = 0;
  foot_force_ = {0, 0};
  body_on_floor_ = false;
  SetTargets(targets);
  PosePeople(model_.get(), *people_, stamp_ns(), d);
  mj_step1(model_.get(), d);
  ThrowOnWarning();
  record_.Clear();
  AppendRecord();
}

void World::SetPeople(std::shared_ptr<const std::vector<PersonWalk>> people) {
  GAITCAM_ASSERT(people->size() == people_->size());
  people_ = std::move(people);
  record_.SetPeople(people_);
}

void World::SetTargets(const std::vector<double>& targets) {
  GAITCAM_ASSERT(targets.size() == actuator_.size());
  for (size_t i = 0; i < targets.size(); ++i) {
    GAITCAM_ASSERT(std::isfinite(targets[i]));
    if (actuator_[i] >= 0) data_->ctrl[actuator_[i]] = targets[i];
  }
}

void World::Step() {
  // mj_step's halves in reverse order, so that kinematics and contacts in `data` are those of the new state.
  mj_step2(model_.get(), data_.get());
  ReadContacts();
  ++step_count_;
  PosePeople(model_.get(), *people_, stamp_ns(), data_.get());
  mj_step1(model_.get(), data_.get());
  ThrowOnWarning();
  AppendRecord();
}

void World::AppendRecord() {
  const mjModel* m = model_.get();
  const mjData* d = data_.get();
  record_.Append(
      {stamp_ns(), std::vector<double>(d->qpos, d->qpos + m->nq), std::vector<double>(d->qvel, d->qvel + m->nv)});
}

void World::ThrowOnWarning() const {
  for (int i = 0; i < mjNWARNING; ++i) {
    if (data_->warning[i].number == 0) continue;
    throw std::runtime_error(fmt::format("MuJoCo at {:.3f} s: {}", 1e-9 * double(stamp_ns()),
                                         mju_warningText(i, data_->warning[i].lastinfo)));
  }
}

void World::ReadContacts() {
  foot_force_ = {0, 0};
  body_on_floor_ = false;
  const mjModel* m = model_.get();
  const mjData* d = data_.get();
  for (int i = 0; i < d->ncon; ++i) {
    const mjContact& contact = d->contact[i];
    if (contact.efc_address < 0) continue;
    double force[6];
    mj_contactForce(m, d, i, force);
    const int scene_geom = IsOfScene(m, contact.geom1) ? contact.geom1 : contact.geom2;
    const int body = m->geom_bodyid[scene_geom == contact.geom1 ? contact.geom2 : contact.geom1];
    if (body == foot_body_[0]) {
      foot_force_[0] += force[0];
    } else if (body == foot_body_[1]) {
      foot_force_[1] += force[0];
    } else if (scene_geom == floor_geom_ && force[0] > 0) {
      body_on_floor_ = true;
    }
  }
}

Pose World::X_WB() const {
  const double* q = data_->qpos;
  if (robot_.kind == Robot::Kind::kOmniBase) {
    return {Eigen::Matrix3d(RotZ(q[2]) * RotY(q[3]) * RotX(q[4])), Eigen::Vector3d(q[0], q[1], robot_.base_height_m)};
  }
  return {Eigen::Quaterniond(q[3], q[4], q[5], q[6]), Eigen::Vector3d(q[0], q[1], q[2])};
}

std::vector<double> World::JointPositions() const {
  std::vector<double> positions(qpos_address_.size(), 0.0);
  for (size_t i = 0; i < positions.size(); ++i) {
    if (qpos_address_[i] >= 0) positions[i] = data_->qpos[qpos_address_[i]];
  }
  return positions;
}

bool World::HasFallen() const {
  if (robot_.kind == Robot::Kind::kOmniBase) return false;
  const Pose pose = X_WB();
  const double up = (pose.rotation * Eigen::Vector3d::UnitZ()).z();
  return pose.translation.z() < 0.65 * standing_height_ || up < 0.6 || body_on_floor_;
}

}  // namespace gaitcam
