#include "sim/walking/posture.h"

#include <gtest/gtest.h>

#include "sim/walking/servo_feedforward.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

class PostureTest : public testing::Test {
 protected:
  PostureTest()
      : robot_(ReadShippedRobot("khr1hv")),
        world_(robot_, Scene{}, PhysicsOptions{}, {}, 1),
        leg_(robot_, 0),
        posture_(robot_, world_.nominal_model(), RootHeight(leg_, 0.015), 0) {
    targets_.com = {0.01, 0};
    for (const int side : {0, 1}) {
      const double y = side == 0 ? 0.04 : -0.04;
      targets_.X_PA[side] = Pose(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, y, leg_.ankle_height()));
    }
  }

  Robot robot_;
  World world_;
  LegKinematics leg_;
  Posture posture_;
  Posture::Targets targets_;
};

TEST_F(PostureTest, PutsTheWholeRobotsCenterOfMassWhereItIsAsked) {
  const Posture::Solution solution = posture_.Solve(targets_, 30);
  world_.SetState(solution.X_PB, posture_.joints());
  // The physics model itself is the judge: its centre of mass, nothing perturbed.
  const mjModel* model = world_.model();
  mj_kinematics(model, world_.data());
  mj_comPos(model, world_.data());
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  for (int body = 1; body < model->nbody; ++body) {
    com += model->body_mass[body] * Eigen::Map<const Eigen::Vector3d>(world_.data()->xipos + 3 * body);
  }
  com /= mj_getTotalmass(model);
  EXPECT_NEAR((com.head<2>() - targets_.com).norm(), 0, 1e-6);
  EXPECT_NEAR(com.z(), posture_.com_height(), 1e-6);
}

TEST_F(PostureTest, FollowsFromTickToTickWithTwoIterations) {
  posture_.Solve(targets_, 30);
  for (int tick = 0; tick < 100; ++tick) {
    targets_.com.y() += 0.0004;  // 0.1 m/s
    posture_.Solve(targets_, 2);
  }
  const Eigen::Vector3d com = posture_.mass_model().CenterOfMass(posture_.joints());
  const Posture::Solution settled = posture_.Solve(targets_, 1);
  EXPECT_NEAR(((settled.X_PB * com).head<2>() - targets_.com).norm(), 0, 1e-4);
}

TEST_F(PostureTest, HoldingTorquesLeaveNothingToAccelerate) {
  // Half the weight under each foot, their sum under the centre of mass: with these forces and the holding torques as
  // the only ones, MuJoCo must find the robot at rest. It floats high over the floor, so that no contact helps.
  Posture::Solution solution = posture_.Solve(targets_, 30);
  const double mass = posture_.mass_model().mass();
  std::array<MassModel::Contact, 2> contacts;
  for (const int side : {0, 1}) {
    const Eigen::Vector3d sole(targets_.com.x(), side == 0 ? 0.04 : -0.04, 0);
    contacts[side] = {solution.X_PB.Inverse() * sole, {0, 0, 0.5 * mass * 9.81}};
  }
  const std::vector<double> torques =
      posture_.mass_model().HoldingTorques(contacts, {posture_.leg(0).joints(), posture_.leg(1).joints()});

  const mjModel* model = world_.model();
  mjData* data = world_.data();
  solution.X_PB.translation.z() += 1;
  world_.SetState(solution.X_PB, posture_.joints());
  mj_forward(model, data);
  mju_zero(data->qfrc_applied, model->nv);
  for (const int side : {0, 1}) {
    const int foot = mj_name2id(model, mjOBJ_BODY, robot_.links[size_t(robot_.legs[side].foot_link)].name.c_str());
    const Eigen::Vector3d point = solution.X_PB * contacts[side].point;
    const double none[3] = {0, 0, 0};
    mj_applyFT(model, data, contacts[side].force.data(), none, point.data(), foot, data->qfrc_applied);
  }
  for (size_t j = 0; j < robot_.joints.size(); ++j) {
    const int id = mj_name2id(model, mjOBJ_JOINT, robot_.joints[j].name.c_str());
    if (id >= 0) data->qfrc_applied[model->jnt_dofadr[id]] += torques[j];
  }
  mj_forward(model, data);
  for (int dof = 0; dof < model->nv; ++dof) {
    // rad/s^2 or m/s^2; gravity alone would show as 9.81, a servo's own weight as tens.
    EXPECT_NEAR(data->qacc_smooth[dof], 0, 0.05) << "degree of freedom " << dof;
  }
}

TEST(ServoFeedforward, UndoesSagAndLag) {
  Robot robot;
  robot.joints.resize(12);
  robot.servos.assign(12, ServoOptions{});  // kp 25, kv 0.25, damping 0.02
  for (int i = 0; i < 12; ++i) robot.legs[i / 6].joints[i % 6] = i;
  ServoFeedforward feedforward(robot, 0.5, 0.004, 1.0);
  std::vector<double> angles(12, 0.2), torques(12, 0.0);
  torques[3] = 0.5;
  std::vector<double> offsets = feedforward.Update(angles, torques);
  EXPECT_DOUBLE_EQ(offsets[3], 0.5 / 12.5);
  EXPECT_DOUBLE_EQ(offsets[4], 0);
  angles[4] += 0.004;  // 1 rad/s
  offsets = feedforward.Update(angles, torques);
  EXPECT_NEAR(offsets[4], (0.125 + 0.02) / 12.5, 1e-12);
}

TEST(ServoFeedforward, DoesNotAskForMoreThanTheServoHas) {
  Robot robot;
  robot.joints.resize(12);
  robot.servos.assign(12, ServoOptions{});
  for (int i = 0; i < 12; ++i) robot.legs[i / 6].joints[i % 6] = i;
  ServoFeedforward feedforward(robot, 1.0, 0.004, 1.0);
  EXPECT_DOUBLE_EQ(feedforward.Update(std::vector<double>(12, 0.0), std::vector<double>(12, 100.0))[0], 1.2 / 25);
}

}  // namespace
}  // namespace gaitcam
