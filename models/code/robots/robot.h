/// A robot: what its URDF says (links, joints, shapes, inertias), and what URDF cannot say, from the YAML file beside
/// it.

#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"
#include "models/code/robots/gait.h"

namespace gaitcam {

/// A primitive, or a mesh file, fixed to a link.
struct RobotShape {
  enum class Kind { kBox, kCylinder, kSphere, kMesh };
  Kind kind = Kind::kBox;
  /// Box: full edges. Cylinder: radius, length (along z), -. Sphere: radius, -, -. Mesh: scale.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  std::filesystem::path mesh;  ///< Existing file; mesh only.
  Pose X_LS;                   ///< Maps shape points into the link.
  Eigen::Vector4d rgba{0.7, 0.7, 0.7, 1};
};

struct RobotLink {
  std::string name;
  double mass_kg = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< In the link frame.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< About the centre of mass, axes of the link frame, kg m^2.
  std::vector<RobotShape> visuals;
  std::vector<RobotShape> collisions;
};

struct RobotJoint {
  enum class Kind { kFixed, kRevolute, kContinuous, kPrismatic };
  std::string name;
  Kind kind = Kind::kFixed;
  int parent_link = -1, child_link = -1;            ///< Indices into Robot::links.
  Pose X_PJ;                                        ///< Joint (= child link) frame in the parent link at zero.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< In the joint frame.
  double lower = 0, upper = 0;                      ///< rad or m; ignored for continuous joints.
};

/// A position servo: torque = kp (target - q) - kv qdot, limited; plus what the gear adds.
struct ServoOptions {
  using DescribedTag = void;
  double kp = 25;
  double kv = 0.25;
  double torque_limit = 1.2;
  double armature = 0.0015;
  double damping = 0.02;
  double friction = 0.02;
};

template <class Visitor>
void VisitFields(Visitor& visit, ServoOptions& o) {
  visit("kp", o.kp, AtLeast(0), "position gain, N m / rad");
  visit("kv", o.kv, AtLeast(0), "velocity gain, N m s / rad");
  visit("torque_limit", o.torque_limit, Positive(), "upper limit of the torque, N m");
  visit("armature", o.armature, AtLeast(0), "reflected rotor inertia, kg m^2");
  visit("damping", o.damping, AtLeast(0), "passive, N m s / rad");
  visit("friction", o.friction, AtLeast(0), "dry friction, N m");
}

/// How an omni base follows its targets for x, y and yaw, and how it rocks on its wheels: damped oscillators, whatever
/// it weighs; and what its computer knows of its wheels. Stiffness is m (2 pi f)^2, damping 2 zeta m (2 pi f), with
/// inertia for m where it turns.
struct DriveOptions {
  using DescribedTag = void;
  double frequency_hz = 5;
  double damping_ratio = 1;
  double rocking_hz = 15;
  double rocking_damping_ratio = 0.2;
  double wheel_radius_m = 0.05;
  double wheel_distance_m = 0.175;
};

template <class Visitor>
void VisitFields(Visitor& visit, DriveOptions& o) {
  visit("frequency_hz", o.frequency_hz, Between(0.1, 50.0), "natural frequency of following x, y and yaw");
  visit("damping_ratio", o.damping_ratio, Between(0.1, 5.0), "of following a target; 1 is critical");
  visit("rocking_hz", o.rocking_hz, Between(1.0, 60.0), "natural frequency of pitch and roll on the wheels");
  visit("rocking_damping_ratio", o.rocking_damping_ratio, Between(0.01, 5.0), "of pitch and roll");
  visit("wheel_radius_m", o.wheel_radius_m, Between(0.005, 1.0), "of each of three omni wheels, for its odometry");
  visit("wheel_distance_m", o.wheel_distance_m, Between(0.01, 5.0), "from the middle to where a wheel touches");
}

/// How a joint of an omni base swings while somebody carries it: with the steps, and with where the hand wanders.
struct SwayOptions {
  using DescribedTag = void;
  std::string joint;
  double per_step = 1;
  double amplitude = 0;
  double phase_deg = 0;
  double wander = 0;
  double wander_hz = 0.1;
};

template <class Visitor>
void VisitFields(Visitor& visit, SwayOptions& o) {
  visit("joint", o.joint, AnyText(), "one that no other entry names");
  visit("per_step", o.per_step, Between(0.1, 10.0), "swings per step: 1 up and down, 0.5 from side to side");
  visit("amplitude", o.amplitude, Between(0.0, 1.0), "of the swing at full speed, m or, of a joint that turns, rad");
  visit("phase_deg", o.phase_deg, Between(-360.0, 360.0), "of the swing when the walk begins");
  visit("wander", o.wander, Between(0.0, 1.0), "slow and random, by seed: standard deviation, m or rad");
  visit("wander_hz", o.wander_hz, Between(0.001, 1.0), "highest frequency of that");
}

/// Six joints from hip to ankle, in the order yaw, roll, pitch, knee, ankle pitch, ankle roll.
struct RobotLeg {
  std::array<int, 6> joints{};  ///< Indices into Robot::joints.
  int foot_link = -1;
  Eigen::Vector3d sole_center = Eigen::Vector3d::Zero();  ///< Middle of the sole, in the foot link.
  Eigen::Vector2d sole_size = Eigen::Vector2d::Zero();    ///< Length, width, m.
};

/// Where a sensor sits. Camera frames are optical: x right, y down, z forward.
struct RobotMount {
  int link = -1;
  Pose X_LS;  ///< Maps points of the sensor frame into the link.
};

struct Robot {
  enum class Kind { kHumanoid, kOmniBase };

  std::string name;
  std::filesystem::path urdf_file, yaml_file;
  Kind kind = Kind::kHumanoid;
  std::vector<RobotLink> links;      ///< Root first; every parent before its children.
  std::vector<RobotJoint> joints;    ///< joints[i].child_link runs over links 1..n-1 in order.
  std::vector<ServoOptions> servos;  ///< Per joint (unused entries for fixed joints).

  std::array<RobotLeg, 2> legs;          ///< Left, right. Humanoids only.
  std::array<int, 2> shoulders{-1, -1};  ///< Joints that swing with the legs, or -1.
  int neck_pan = -1, neck_tilt = -1;     ///< Joint indices, or -1.
  int camera_pan = -1;                   ///< A second joint that turns the camera left, carried by the neck's; or -1.
  double base_height_m = 0;              ///< Omni base: height of the root link over the floor.
  DriveOptions drive;                    ///< Omni base.
  double walk_ratio_m_s = 0;             ///< Omni base that is carried: a step's length over the rate of steps.
  std::vector<SwayOptions> sway;         ///< Of that base.
  RobotMount camera, imu;
  std::map<std::string, GaitOptions> gaits;  ///< Presets by name.
  std::map<std::string, double> control;     ///< Feedback gains of the walk that differ from its defaults.

  /// @returns index, or -1.
  int FindLink(const std::string& name) const;
  int FindJoint(const std::string& name) const;
  double TotalMass() const;
};
constexpr auto WordsOf(Robot::Kind) {
  return std::array{EnumWord{Robot::Kind::kHumanoid, "humanoid"}, EnumWord{Robot::Kind::kOmniBase, "omni_base"}};
}

/// Reads a shipped robot by name, or any robot by the path of its YAML file (which names the URDF beside it).
/// @param models_folder where the shipped robots lie (`robots/NAME/NAME.yaml`).
/// @throws BadInput naming file, element and what is expected.
Robot ReadRobot(const std::string& name_or_path, const std::filesystem::path& models_folder);

/// Poses X_RL of all links in the root link for joint positions in the order of Robot::joints.
std::vector<Pose> LinkPoses(const Robot& robot, const std::vector<double>& joint_positions);

/// Names of the shipped robots, sorted.
std::vector<std::string> ListRobots(const std::filesystem::path& models_folder);

}  // namespace gaitcam
