#include <algorithm>

#include "algorithms/core/errors.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

void UpdateKinematics(const mjModel* model, mjData* data) {
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_camlight(model, data);
}

}  // namespace

void MotionRecord::Append(PhysicsState state) {
  GAITCAM_ASSERT(states_.empty() || state.stamp_ns > states_.back().stamp_ns);
  states_.push_back(std::move(state));
}

void MotionRecord::DropBefore(int64_t stamp_ns) {
  while (states_.size() > 1 && states_[1].stamp_ns <= stamp_ns) states_.pop_front();
}

void PosePeople(const mjModel* model, const std::vector<PersonWalk>& people, int64_t stamp_ns, mjData* data) {
  GAITCAM_ASSERT(model->nmocap == int(people.size()) * kPersonParts);
  mjtNum *position = data->mocap_pos, *rotation = data->mocap_quat;
  for (const PersonWalk& person : people) {
    for (const Pose& X_WP : person.At(1e-9 * double(stamp_ns))) {
      const Eigen::Quaterniond& q = X_WP.rotation;
      position = std::copy_n(X_WP.translation.data(), 3, position);
      for (const double value : {q.w(), q.x(), q.y(), q.z()}) *rotation++ = value;
    }
  }
}

void MotionRecord::PutRobot(const mjModel* model, int64_t stamp_ns, mjData* data) const {
  GAITCAM_ASSERT(!states_.empty() && stamp_ns >= first_stamp_ns() && stamp_ns <= last_stamp_ns());
  const auto later = std::upper_bound(states_.begin(), states_.end(), stamp_ns,
                                      [](int64_t stamp, const PhysicsState& s) { return stamp < s.stamp_ns; });
  const PhysicsState& before = *(later - 1);
  GAITCAM_ASSERT(int(before.qpos.size()) == model->nq);
  std::copy(before.qpos.begin(), before.qpos.end(), data->qpos);
  if (stamp_ns > before.stamp_ns) {
    mj_integratePos(model, data->qpos, later->qvel.data(), 1e-9 * double(stamp_ns - before.stamp_ns));
  }
  data->time = 1e-9 * double(stamp_ns);
}

void MotionRecord::Evaluate(const mjModel* model, int64_t stamp_ns, mjData* data) const {
  PutRobot(model, stamp_ns, data);
  if (people_) PosePeople(model, *people_, stamp_ns, data);
  UpdateKinematics(model, data);
}

void MotionRecord::EvaluateRobot(const mjModel* model, int64_t stamp_ns, mjData* data) const {
  PutRobot(model, stamp_ns, data);
  mjModel alone = *model;  // people come last; only this shallow copy is shorter
  alone.nbody = FirstPersonBody(model);
  if (alone.nbody < model->nbody) alone.ngeom = model->body_geomadr[alone.nbody];
  UpdateKinematics(&alone, data);
}

}  // namespace gaitcam
