#include "models/code/robots/robot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "algorithms/core/errors.h"
#include "tests/data_folder.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

/// A user's copy of khr1hv in a folder of its own, to be spoiled by one replacement.
class UserRobot : public testing::Test {
 protected:
  UserRobot() {
    urdf_ = ReadText(kModels / "robots/khr1hv/khr1hv.urdf");
    yaml_ = ReadText(kModels / "robots/khr1hv/khr1hv.yaml");
  }

  static void Replace(std::string& text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  /// Cuts from the first `from` to the end of the next `to`.
  static void Cut(std::string& text, const std::string& from, const std::string& to) {
    const size_t begin = text.find(from), end = text.find(to, begin);
    ASSERT_NE(end, std::string::npos) << from;
    text.erase(begin, end + to.size() - begin);
  }
  Robot Read() {
    folder_.Write("khr1hv.urdf", urdf_);
    return ReadRobot(folder_.Write("mine.yaml", yaml_).string(), kModels);
  }
  /// The error's text without the folder; it must be one line, and nothing may go to the console.
  std::string Error() {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    std::string text;
    try {
      Read();
    } catch (const BadInput& e) {
      text = e.what();
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    const std::string folder = folder_.path().string() + "/";
    for (size_t at; (at = text.find(folder)) != std::string::npos;) text.erase(at, folder.size());
    return text;
  }

  const TemporaryFolder folder_;
  std::string urdf_, yaml_;
};

TEST(Robot, ShippedOnesAreListedAndRead) {
  EXPECT_THAT(ListRobots(kModels),
              testing::ElementsAre("handheld", "khr1hv", "khr1hv_pan", "nimbro", "omni_base", "robovie_m"));
  for (const std::string& name : ListRobots(kModels)) {
    const Robot robot = ReadRobot(name, kModels);
    EXPECT_EQ(robot.name, name);
    EXPECT_EQ(robot.links.size(), robot.joints.size() + 1);
    EXPECT_EQ(robot.servos.size(), robot.joints.size());
    for (size_t i = 0; i < robot.joints.size(); ++i) {
      EXPECT_EQ(robot.joints[i].child_link, int(i) + 1);
      EXPECT_LT(robot.joints[i].parent_link, int(i) + 1);
    }
    for (const char* preset : {"slow", "normal", "brisk"}) EXPECT_TRUE(robot.gaits.count(preset)) << name;
    EXPECT_GE(robot.neck_pan, 0);
    EXPECT_GE(robot.neck_tilt, 0);
  }
}

TEST(Robot, OnlyJointsThatMoveSwayAndEachButOnce) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& from, const std::string& to) {
    std::string yaml = ReadText(kModels / "robots/handheld/handheld.yaml");
    const size_t at = yaml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    yaml.replace(at, from.size(), to);
    folder.Write("handheld.urdf", ReadText(kModels / "robots/handheld/handheld.urdf"));
    const std::string file = folder.Write("mine.yaml", yaml).string();
    return ErrorOf([&] { ReadRobot(file, kModels); });
  };
  EXPECT_THAT(error("{joint: hand_roll", "{joint: camera_mount"), HasSubstr("joint \"camera_mount\" is fixed"));
  EXPECT_THAT(error("{joint: hand_roll", "{joint: hand_rol"), HasSubstr("hand_roll"));
  EXPECT_THAT(error("{joint: hand_roll", "{joint: hand_yaw"), HasSubstr("joint \"hand_yaw\" is named twice"));
  EXPECT_THAT(error("walk_ratio_m_s: 0.39", ""), HasSubstr("walk_ratio_m_s above 0"));
  EXPECT_THAT(error("amplitude: 0.026", "amplitude: -0.1"), HasSubstr("amplitude"));
}

int MovingJoints(const Robot& robot) {
  int count = 0;
  for (const RobotJoint& joint : robot.joints) count += joint.kind != RobotJoint::Kind::kFixed;
  return count;
}

/// From the sole to the highest corner of any shape, all joints at zero.
double StandingHeight(const Robot& robot) {
  const std::vector<Pose> poses = LinkPoses(robot, std::vector<double>(robot.joints.size(), 0.0));
  double top = 0;
  for (size_t i = 0; i < robot.links.size(); ++i) {
    for (const RobotShape& shape : robot.links[i].collisions)
      top = std::max(top, (poses[i] * shape.X_LS.translation).z());
  }
  return top - (poses[robot.legs[0].foot_link] * robot.legs[0].sole_center).z();
}

TEST(Robot, ThePanningCameraChangesNothingOfKhr1hvButItsHead) {
  const Robot khr = ReadRobot("khr1hv", kModels), pan = ReadRobot("khr1hv_pan", kModels);
  EXPECT_NEAR(pan.TotalMass(), khr.TotalMass(), 1e-12);
  const std::vector<Pose> X_RL = LinkPoses(khr, std::vector<double>(khr.joints.size(), 0.0));
  const std::vector<Pose> X_RP = LinkPoses(pan, std::vector<double>(pan.joints.size(), 0.0));
  for (const RobotLink& link : khr.links) {
    const int same = pan.FindLink(link.name);
    ASSERT_GE(same, 0) << link.name;
    const RobotLink& twin = pan.links[size_t(same)];
    EXPECT_LT((X_RP[size_t(same)].translation - X_RL[size_t(khr.FindLink(link.name))].translation).norm(), 1e-12);
    if (link.name == "head") continue;
    EXPECT_EQ(twin.mass_kg, link.mass_kg) << link.name;
    EXPECT_EQ(twin.inertia, link.inertia) << link.name;
    EXPECT_EQ(twin.collisions.size(), link.collisions.size()) << link.name;
  }
  EXPECT_EQ(khr.camera_pan, -1);
  // Neck and camera pan about the same vertical, the camera's tilt comes after both.
  EXPECT_EQ(pan.joints[size_t(pan.camera_pan)].parent_link, pan.joints[size_t(pan.neck_pan)].child_link);
  EXPECT_EQ(pan.joints[size_t(pan.neck_tilt)].parent_link, pan.joints[size_t(pan.camera_pan)].child_link);
  EXPECT_EQ(pan.servos[size_t(pan.camera_pan)].kp, pan.servos[size_t(pan.neck_pan)].kp);
}

TEST(Robot, DimensionsFollowTheRealMachines) {
  const Robot khr = ReadRobot("khr1hv", kModels), robovie = ReadRobot("robovie_m", kModels);
  const Robot nimbro = ReadRobot("nimbro", kModels), base = ReadRobot("omni_base", kModels);
  EXPECT_GE(MovingJoints(khr), 17);
  EXPECT_EQ(MovingJoints(robovie), 22);
  EXPECT_NEAR(khr.TotalMass(), 1.62, 1e-6);
  EXPECT_NEAR(robovie.TotalMass(), 1.9, 1e-6);
  EXPECT_GT(nimbro.TotalMass(), 2.3);
  EXPECT_LT(nimbro.TotalMass(), 3.0);
  // To the middle of the head, so somewhat less than the whole machine.
  EXPECT_NEAR(StandingHeight(khr), 0.33, 0.02);
  EXPECT_NEAR(StandingHeight(robovie), 0.27, 0.02);
  EXPECT_NEAR(StandingHeight(nimbro), 0.56, 0.03);
  const std::vector<Pose> poses = LinkPoses(base, std::vector<double>(base.joints.size(), 0.0));
  EXPECT_NEAR(base.base_height_m + (poses[base.camera.link] * base.camera.X_LS).translation.z(), 1.3, 1e-9);
}

TEST(Robot, CamerasLookForwardAndLegsAreMirrored) {
  for (const std::string& name : ListRobots(kModels)) {
    const Robot robot = ReadRobot(name, kModels);
    const std::vector<Pose> poses = LinkPoses(robot, std::vector<double>(robot.joints.size(), 0.0));
    const Eigen::Matrix3d R = (poses[robot.camera.link] * robot.camera.X_LS).R();
    // Angles in the URDF are written with 10 digits.
    EXPECT_LT((R.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-8) << "z forward";
    EXPECT_LT((R.col(0) + Eigen::Vector3d::UnitY()).norm(), 1e-8) << "x right";
    if (robot.kind != Robot::Kind::kHumanoid) continue;
    const Eigen::Vector3d left = poses[robot.legs[0].foot_link] * robot.legs[0].sole_center;
    const Eigen::Vector3d right = poses[robot.legs[1].foot_link] * robot.legs[1].sole_center;
    EXPECT_LT((left - Eigen::Vector3d(right.x(), -right.y(), right.z())).norm(), 1e-12);
    EXPECT_GT(left.y(), 0);
  }
}

TEST(Robot, ServosComeByClassAndSolesFromTheFootBox) {
  const Robot robot = ReadRobot("khr1hv", kModels);
  EXPECT_EQ(robot.servos[robot.legs[1].joints[3]].kp, 25);
  EXPECT_EQ(robot.servos[robot.neck_pan].kp, 3);
  EXPECT_EQ(robot.servos[robot.neck_tilt].torque_limit, 0.4);
  EXPECT_LT((robot.legs[0].sole_center - Eigen::Vector3d(0.008, 0.003, -0.03)).norm(), 1e-12);
  EXPECT_LT((robot.legs[0].sole_size - Eigen::Vector2d(0.1, 0.06)).norm(), 1e-12);
}

TEST(Robot, LinkPosesTurnWithTheJoints) {
  const Robot robot = ReadRobot("khr1hv", kModels);
  std::vector<double> joints(robot.joints.size(), 0.0);
  joints[robot.legs[0].joints[2]] = -std::numbers::pi / 2;  // left hip pitch: thigh level, forward
  const Pose shank = LinkPoses(robot, joints)[robot.FindLink("l_shank")];
  EXPECT_LT((shank.translation - Eigen::Vector3d(0.065, 0.04, 0)).norm(), 1e-12);
}

TEST(Robot, UnknownNameNamesTheNearest) {
  try {
    ReadRobot("khr1hw", kModels);
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_STREQ(e.what(), "robot \"khr1hw\" is unknown; did you mean khr1hv?");
  }
  EXPECT_THROW(ReadRobot("there/is/nothing.yaml", kModels), BadInput);
}

TEST_F(UserRobot, ReadsTheSameByPath) {
  const Robot mine = Read(), shipped = ReadRobot("khr1hv", kModels);
  EXPECT_EQ(mine.name, "mine");
  ASSERT_EQ(mine.links.size(), shipped.links.size());
  EXPECT_EQ(mine.TotalMass(), shipped.TotalMass());
}

TEST_F(UserRobot, LackingLegJointIsNamed) {
  Replace(yaml_, "l_knee", "l_kneee");
  EXPECT_EQ(Error(), "mine.yaml:7:50: legs.left.joints[3]: khr1hv.urdf has no joint \"l_kneee\"; did you mean l_knee?");
}

TEST_F(UserRobot, LegJointsMustFormTheChain) {
  Replace(yaml_, "l_hip_yaw, l_hip_roll", "l_hip_roll, l_hip_yaw");
  EXPECT_THAT(Error(), HasSubstr("legs.left.joints[0]: joint \"l_hip_roll\" does not carry joint \"l_hip_yaw\""));
  Replace(yaml_, "l_hip_roll, l_hip_yaw, ", "");
  EXPECT_THAT(Error(), HasSubstr("legs.left.joints: 4 joints; expected 6: hip yaw"));
}

TEST_F(UserRobot, LackingCameraLinkIsNamed) {
  Replace(yaml_, "camera: {link: camera}", "camera: {link: eye}");
  EXPECT_EQ(Error(),
            "mine.yaml:14:16: camera.link: khr1hv.urdf has no link \"eye\"; expected the name of one of its links");
  Replace(yaml_, "camera: {link: eye}", "");
  EXPECT_THAT(Error(), HasSubstr("expected key camera: {link: NAME"));
}

TEST_F(UserRobot, UnknownKeyNamesTheNearest) {
  Replace(yaml_, "shoulders:", "sholders:");
  EXPECT_THAT(Error(), HasSubstr("mine.yaml:12:1: sholders: unknown key; did you mean shoulders?"));
}

TEST_F(UserRobot, LackingInertiaIsNamedUnlessTheYamlGivesAMass) {
  Cut(urdf_, "    <inertial>", "</inertial>\n");  // the trunk's
  EXPECT_THAT(Error(), testing::MatchesRegex("khr1hv.urdf:[0-9]+: link \"trunk\" moves but has no mass; expected "
                                             "<inertial>, or its mass under masses in the YAML file"));
  yaml_ += "masses: {trunk: 0.6}\n";
  const Robot robot = Read();
  EXPECT_EQ(robot.links[0].mass_kg, 0.6);
  // Two boxes filled with one density: volumes 0.05 x 0.11 x 0.028 at z 0.012 and 0.06 x 0.10 x 0.09 at z 0.080.
  const double v1 = 0.05 * 0.11 * 0.028, v2 = 0.06 * 0.10 * 0.09;
  const double z = (v1 * 0.012 + v2 * 0.080) / (v1 + v2), m1 = 0.6 * v1 / (v1 + v2), m2 = 0.6 - m1;
  EXPECT_NEAR(robot.links[0].com.z(), z, 1e-12);
  const double ixx = m1 * ((0.11 * 0.11 + 0.028 * 0.028) / 12 + (0.012 - z) * (0.012 - z)) +
                     m2 * ((0.10 * 0.10 + 0.09 * 0.09) / 12 + (0.080 - z) * (0.080 - z));
  EXPECT_NEAR(robot.links[0].inertia(0, 0), ixx, 1e-12);
}

TEST_F(UserRobot, MassesInTheYamlArePositiveAndForKnownLinksWithoutInertia) {
  const std::string good = yaml_;
  yaml_ = good + "masses: {trunk: -1}\n";
  EXPECT_THAT(Error(), HasSubstr("masses.trunk: expected a mass above 0 kg"));
  yaml_ = good + "masses: {trunk: .nan}\n";
  EXPECT_THAT(Error(), HasSubstr("masses.trunk: .nan is not permitted; expected a number from"));
  yaml_ = good + "masses: {trunk: 1}\n";
  EXPECT_THAT(Error(), HasSubstr("link \"trunk\" has an <inertial> already"));
  yaml_ = good + "masses: {trank: 1}\n";
  EXPECT_THAT(Error(), HasSubstr("no link \"trank\""));
}

TEST_F(UserRobot, InertiaThatNoBodyHasIsRefused) {
  Replace(urdf_, "ixx=\"0.00140938\"", "ixx=\"0.0140938\"");
  EXPECT_THAT(Error(),
              testing::AllOf(HasSubstr("khr1hv.urdf:"), HasSubstr("link \"trunk\": inertia with principal moments"),
                             HasSubstr("0.01409")));
}

TEST_F(UserRobot, ZeroMassIsRefused) {
  Replace(urdf_, "<mass value=\"0.6\"/>", "<mass value=\"0\"/>");
  EXPECT_THAT(Error(), HasSubstr("link \"trunk\": mass 0 kg; expected more than 0"));
}

TEST_F(UserRobot, MissingMeshIsNamed) {
  Replace(urdf_, "<box size=\"0.044 0.104 0.026\"/>", "<mesh filename=\"package://mine/meshes/trunk.stl\"/>");
  EXPECT_THAT(Error(),
              HasSubstr("link \"trunk\": mesh \"package://mine/meshes/trunk.stl\" is not there; expected a file "
                        "meshes/trunk.stl"));
  const std::filesystem::path mesh = folder_.Write("meshes/trunk.stl", "solid");
  EXPECT_EQ(Read().links[0].visuals[0].mesh, mesh);
  Replace(urdf_, "trunk.stl", "trunk.dae");
  folder_.Write("meshes/trunk.dae", "<xml/>");
  EXPECT_THAT(Error(), HasSubstr("expected a file of type .stl or .obj"));
}

TEST_F(UserRobot, MovingJointNeedsAxisAndLimit) {
  Replace(urdf_, "    <axis xyz=\"0 0 1\"/>\n", "");
  EXPECT_THAT(Error(), testing::MatchesRegex("khr1hv.urdf:[0-9]+: joint \"l_hip_yaw\": expected <axis xyz=\"...\"/>"));
  Replace(urdf_, "<limit lower=\"-1\" upper=\"1\"", "<axis xyz=\"0 0 1\"/><limit upper=\"1\"");
  EXPECT_THAT(Error(), HasSubstr("joint \"l_hip_yaw\": expected <limit> with lower and upper"));
}

TEST_F(UserRobot, TreeMustHaveOneRootThatReachesAll) {
  const std::string good = urdf_;
  Replace(urdf_, "</robot>", "<link name=\"stray\"/></robot>");
  EXPECT_THAT(Error(), HasSubstr("link \"stray\" is a second root beside \"trunk\""));
  urdf_ = good;
  Replace(urdf_, "</robot>",
          "<link name=\"a\"/><link name=\"b\"/>"
          "<joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>"
          "<joint name=\"ba\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>");
  EXPECT_THAT(Error(), HasSubstr("link \"a\" cannot be reached from root link \"trunk\""));
  urdf_ = good;
  Replace(urdf_, "<parent link=\"trunk\"/>", "<parent link=\"tronk\"/>");
  EXPECT_THAT(Error(), HasSubstr("parent link \"tronk\" does not exist; did you mean trunk?"));
}

/// Found by fuzzing: a value in a message of urdfdom was taken for a format of printf.
TEST_F(UserRobot, ValuesThatAPrintfWouldReadAreRefused) {
  const std::string good = urdf_;
  for (const std::string value : {"%n%n%n%n", "0.6%s%s%s%s", "%1$n"}) {
    urdf_ = good;
    Replace(urdf_, "<mass value=\"0.6\"/>", "<mass value=\"" + value + "\"/>");
    EXPECT_THAT(Error(), testing::AllOf(testing::ContainsRegex("^khr1hv.urdf:[0-9]+: "),
                                        HasSubstr("value \"" + value + "\"; expected a value without %")));
  }
  urdf_ = good;
  Replace(urdf_, "<mass value=\"0.6\"/>", "<mass value=\"&#37;n\"/>");
  EXPECT_THAT(Error(), HasSubstr("value \"%n\"; expected a value without %"));
  urdf_ = good;
  Replace(urdf_, "</robot>", "<gazebo><plugin filename=\"%s.so\"/></gazebo></robot>");
  EXPECT_EQ(Error(), "");
}

/// Found by fuzzing: the two XML readers took such a name for two names, and a joint that was not there was looked
/// into.
TEST_F(UserRobot, ANameWithAStrayAmpersandIsRefused) {
  const std::string good = urdf_;
  for (const auto& [joint, link, culprit] :
       {std::array{"nec&k", "tip", "joint \"nec&k\""}, std::array{"tip_joint", "ti&p", "link \"ti&p\""}}) {
    urdf_ = good;
    Replace(urdf_, "</robot>",
            fmt::format("<joint name=\"{}\" type=\"fixed\"><parent link=\"trunk\"/><child link=\"{}\"/></joint>"
                        "<link name=\"{}\"/></robot>",
                        joint, link, link));
    EXPECT_THAT(Error(), testing::AllOf(testing::ContainsRegex("^khr1hv.urdf:[0-9]+: "),
                                        HasSubstr(culprit + std::string(": urdfdom reads another name"))));
  }
}

TEST_F(UserRobot, BrokenFilesAreNamed) {
  const std::string good = urdf_;
  urdf_ = "<robot name=\"x\"><link name=\"a\"></robot>";
  EXPECT_THAT(Error(), HasSubstr("khr1hv.urdf:1:"));
  urdf_ = "<mujoco/>";
  EXPECT_THAT(Error(), HasSubstr("expected a URDF file with root element <robot>"));
  urdf_ = good;
  Replace(urdf_, "<mass value=\"0.6\"/>", "<mass value=\"heavy\"/>");  // found by urdfdom, which says so on the console
  EXPECT_THAT(Error(), testing::AllOf(HasSubstr("khr1hv.urdf: "), HasSubstr("mass")));
  urdf_ = good;
  Replace(yaml_, "urdf: khr1hv.urdf", "urdf: other.urdf");
  EXPECT_EQ(Error(), "other.urdf: cannot read this file");
}

}  // namespace
}  // namespace gaitcam
