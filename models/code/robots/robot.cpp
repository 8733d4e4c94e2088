#include "models/code/robots/robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/file_names.h"
#include "models/code/robots/robot_urdf.h"
#include "models/code/yaml/yaml_reader.h"

namespace gaitcam {

/// Found by the reader of described structs, hence not in the unnamed namespace.
static void ReadOption(const OptionValue& node, std::map<std::string, GaitOptions>& value) {
  if (!node.IsMap()) node.Fail("expected a map of names and gaits");
  for (const auto& entry : node.entries()) ReadOption(node.Child(entry.key), value[entry.key]);
}

namespace {

/// The YAML file as it is written; names become indices in RobotBuilder.
struct LegFile {
  using DescribedTag = void;
  std::vector<std::string> joints;
  std::string foot;
  std::optional<Eigen::Vector3d> sole_center;
  std::optional<Eigen::Vector2d> sole_size;
};

struct LegsFile {
  using DescribedTag = void;
  LegFile left, right;
};

struct NeckFile {
  using DescribedTag = void;
  std::string pan, tilt, camera_pan;
};

struct MountFile {
  using DescribedTag = void;
  std::string link;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy_deg = Eigen::Vector3d::Zero();
};

struct ServosFile {
  using DescribedTag = void;
  ServoOptions legs, arms, neck;
};

struct RobotFile {
  using DescribedTag = void;
  std::string urdf;
  Robot::Kind kind = Robot::Kind::kHumanoid;
  std::map<std::string, double> masses;
  LegsFile legs;
  std::vector<std::string> shoulders;
  NeckFile neck;
  MountFile camera, imu;
  ServosFile servos;
  double base_height_m = 0;
  DriveOptions drive;
  double walk_ratio_m_s = 0;
  std::vector<SwayOptions> sway;
  std::map<std::string, GaitOptions> gaits;
  std::map<std::string, double> control;
};

template <class Visitor>
void VisitFields(Visitor& visit, LegFile& o) {
  visit("joints", o.joints, Nested(), "yaw, roll, pitch, knee, ankle pitch, ankle roll");
  visit("foot", o.foot, AnyText(), "link with the sole");
  visit("sole_center", o.sole_center, Nested(), "middle of the sole in the foot link; default: of the foot's one box");
  visit("sole_size", o.sole_size, Nested(), "length and width of the sole, m; default: of the foot's one box");
}

template <class Visitor>
void VisitFields(Visitor& visit, LegsFile& o) {
  visit("left", o.left, Nested(), "left leg");
  visit("right", o.right, Nested(), "right leg");
}

template <class Visitor>
void VisitFields(Visitor& visit, NeckFile& o) {
  visit("pan", o.pan, AnyText(), "joint that turns the head left");
  visit("tilt", o.tilt, AnyText(), "joint that turns the head down");
  visit("camera_pan", o.camera_pan, AnyText(), "second joint that turns the camera left, beyond the neck's reach");
}

template <class Visitor>
void VisitFields(Visitor& visit, MountFile& o) {
  visit("link", o.link, AnyText(), "link that carries the sensor");
  visit("position", o.position, Nested(), "of the sensor frame in the link, m");
  visit("rpy_deg", o.rpy_deg, Nested(), "of the sensor frame in the link, as in URDF but in degrees");
}

template <class Visitor>
void VisitFields(Visitor& visit, ServosFile& o) {
  visit("legs", o.legs, Nested(), "servos of the leg joints");
  visit("arms", o.arms, Nested(), "servos of all other joints");
  visit("neck", o.neck, Nested(), "servos of the neck joints");
}

template <class Visitor>
void VisitFields(Visitor& visit, RobotFile& o) {
  visit("urdf", o.urdf, AnyText(), "URDF file, beside this one");
  visit("kind", o.kind, EnumWords<Robot::Kind>(), "what it is");
  visit("masses", o.masses, Nested(), "kg of links without <inertial>");
  visit("legs", o.legs, Nested(), "joints and feet of a humanoid");
  visit("shoulders", o.shoulders, Nested(), "left and right joint that swing with the legs");
  visit("neck", o.neck, Nested(), "joints that turn the camera");
  visit("camera", o.camera, Nested(), "mount; the frame is optical: x right, y down, z forward");
  visit("imu", o.imu, Nested(), "mount");
  visit("servos", o.servos, Nested(), "gains and limits");
  visit("base_height_m", o.base_height_m, Between(0, 10), "height of an omni base's root link over the floor");
  visit("drive", o.drive, Nested(), "how an omni base follows its targets");
  visit("walk_ratio_m_s", o.walk_ratio_m_s, Between(0, 10),
        "of who carries an omni base: length of a step over steps per second");
  visit("sway", o.sway, Nested(), "how its joints swing with the steps");
  visit("gaits", o.gaits, Nested(), "presets");
  visit("control", o.control, Nested(), "gains of the walk that differ from the defaults");
}

/// Turns the YAML file's names into indices; every error points into that file.
class RobotBuilder {
 public:
  explicit RobotBuilder(const std::filesystem::path& yaml) : root_(LoadYaml(yaml)) {
    robot_.yaml_file = yaml;
    robot_.name = yaml.stem().string();
  }

  Robot Build() {
    ReadOption(root_, file_);
    if (!root_.Has("urdf")) root_.Fail("expected key urdf with the name of the URDF file beside this one");
    robot_.urdf_file = root_.folder() / file_.urdf;
    for (const auto& [link, kg] : file_.masses) {
      if (!(kg > 0)) root_.Child("masses").Child(link).Fail("expected a mass above 0 kg");
    }
    robot_.kind = file_.kind;
    UrdfTree tree = ReadUrdf(robot_.urdf_file, file_.masses);
    robot_.links = std::move(tree.links);
    robot_.joints = std::move(tree.joints);
    if (root_.Has("neck")) ReadNeck();
    if (robot_.kind == Robot::Kind::kHumanoid) ReadHumanoid();
    ReadServos(tree.efforts);
    robot_.camera = ReadMount("camera", file_.camera);
    robot_.imu = ReadMount("imu", file_.imu);
    robot_.base_height_m = file_.base_height_m;
    robot_.drive = file_.drive;
    ReadSway();
    robot_.gaits = file_.gaits;
    robot_.control = file_.control;
    return std::move(robot_);
  }

 private:
  template <class Elements>
  int Find(const OptionValue& at, const std::string& name, const Elements& elements, const std::string& kind) const {
    std::vector<std::string> names;
    names.reserve(elements.size());
    for (const auto& element : elements) names.push_back(element.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return int(found - names.begin());
    at.Fail(fmt::format("{} has no {} \"{}\"; {}", robot_.urdf_file.string(), kind, name,
                        DidYouMean(name, names, "expected the name of one of its " + kind + "s")));
  }

  int MovingJoint(const OptionValue& at, const std::string& name) const {
    const int index = Find(at, name, robot_.joints, "joint");
    const auto kind = robot_.joints[index].kind;
    if (kind != RobotJoint::Kind::kRevolute && kind != RobotJoint::Kind::kContinuous) {
      at.Fail("joint \"" + name + "\" does not turn; expected one of type revolute or continuous");
    }
    return index;
  }

  OptionValue Required(const OptionValue& map, const std::string& key, const std::string& expected) const {
    if (!map.Has(key)) map.Fail("expected key " + key + ": " + expected);
    return map.Child(key);
  }

  void ReadNeck() {
    const OptionValue neck = root_.Child("neck");
    if (neck.Has("pan")) robot_.neck_pan = MovingJoint(neck.Child("pan"), file_.neck.pan);
    if (neck.Has("tilt")) robot_.neck_tilt = MovingJoint(neck.Child("tilt"), file_.neck.tilt);
    if (neck.Has("camera_pan")) robot_.camera_pan = MovingJoint(neck.Child("camera_pan"), file_.neck.camera_pan);
  }

  void ReadHumanoid() {
    const OptionValue legs = Required(root_, "legs", "joints and feet of left and right");
    robot_.legs[0] = ReadLeg(Required(legs, "left", "joints and foot"), file_.legs.left);
    robot_.legs[1] = ReadLeg(Required(legs, "right", "joints and foot"), file_.legs.right);
    if (!root_.Has("shoulders")) return;
    const OptionValue shoulders = root_.Child("shoulders");
    if (file_.shoulders.size() != 2) shoulders.Fail("expected a list of 2 joints, left and right");
    for (int side = 0; side < 2; ++side) {
      robot_.shoulders[side] = MovingJoint(shoulders.Element(side), file_.shoulders[side]);
    }
  }

  RobotLeg ReadLeg(const OptionValue& node, const LegFile& file) const {
    const OptionValue joints = Required(node, "joints", "hip yaw, roll, pitch, knee, ankle pitch, ankle roll");
    RobotLeg leg;
    if (file.joints.size() != leg.joints.size()) {
      joints.Fail(fmt::format("{} joints; expected 6: hip yaw, roll, pitch, knee, ankle pitch, ankle roll",
                              file.joints.size()));
    }
    for (size_t i = 0; i < leg.joints.size(); ++i) leg.joints[i] = MovingJoint(joints.Element(i), file.joints[i]);
    const OptionValue foot = Required(node, "foot", "the link with the sole");
    leg.foot_link = Find(foot, file.foot, robot_.links, "link");
    for (size_t i = 0; i < leg.joints.size(); ++i) {
      const int next = i + 1 < leg.joints.size() ? robot_.joints[leg.joints[i + 1]].parent_link : leg.foot_link;
      if (CarriedBy(next) != CarriedBy(robot_.joints[leg.joints[i]].child_link)) {
        joints.Element(i).Fail("joint \"" + file.joints[i] + "\" does not carry " +
                               (i + 1 < leg.joints.size() ? "joint \"" + file.joints[i + 1] : "link \"" + file.foot) +
                               "\"; expected the chain from hip to foot");
      }
    }
    ReadSole(node, file, leg);
    return leg;
  }

  /// The link itself, or the nearest ancestor that moves against its parent: fixed links are one body with it.
  int CarriedBy(int link) const {
    while (link > 0 && robot_.joints[link - 1].kind == RobotJoint::Kind::kFixed)
      link = robot_.joints[link - 1].parent_link;
    return link;
  }

  void ReadSole(const OptionValue& node, const LegFile& file, RobotLeg& leg) const {
    const auto& shapes = robot_.links[leg.foot_link].collisions;
    const bool one_box = shapes.size() == 1 && shapes[0].kind == RobotShape::Kind::kBox &&
                         shapes[0].X_LS.R().isApprox(Eigen::Matrix3d::Identity(), 1e-9);
    if (one_box) {
      leg.sole_center = shapes[0].X_LS.translation - Eigen::Vector3d(0, 0, shapes[0].size.z() / 2);
      leg.sole_size = shapes[0].size.head<2>();
    } else if (!file.sole_center || !file.sole_size) {
      node.Fail("expected sole_center and sole_size, as the <collision> of link \"" + file.foot +
                "\" is not one box along its axes");
    }
    if (file.sole_center) leg.sole_center = *file.sole_center;
    if (file.sole_size) leg.sole_size = *file.sole_size;
    if (!(leg.sole_size.minCoeff() > 0)) node.Child("sole_size").Fail("expected a length and a width above 0");
  }

  void ReadServos(const std::vector<double>& efforts) {
    robot_.servos.assign(robot_.joints.size(), file_.servos.arms);
    for (const RobotLeg& leg : robot_.legs) {
      if (robot_.kind != Robot::Kind::kHumanoid) break;
      for (int joint : leg.joints) robot_.servos[joint] = file_.servos.legs;
    }
    for (int joint : {robot_.neck_pan, robot_.neck_tilt, robot_.camera_pan}) {
      if (joint >= 0) robot_.servos[joint] = file_.servos.neck;
    }
    for (size_t i = 0; i < efforts.size(); ++i) {
      if (efforts[i] > 0) robot_.servos[i].torque_limit = std::min(robot_.servos[i].torque_limit, efforts[i]);
    }
  }

  void ReadSway() {
    if (file_.sway.empty()) return;
    const OptionValue list = root_.Child("sway");
    if (robot_.kind != Robot::Kind::kOmniBase) list.Fail("only the joints of an omni_base sway; a humanoid's walk");
    if (!(file_.walk_ratio_m_s > 0)) list.Fail("expected a walk_ratio_m_s above 0 beside it, 0.4 of most people");
    for (size_t i = 0; i < file_.sway.size(); ++i) {
      const OptionValue entry = list.Element(i);
      const std::string& name = file_.sway[i].joint;
      const OptionValue at = Required(entry, "joint", "the joint that swings");
      if (robot_.joints[size_t(Find(at, name, robot_.joints, "joint"))].kind == RobotJoint::Kind::kFixed)
        at.Fail("joint \"" + name + "\" is fixed; expected one that moves");
      for (size_t k = 0; k < i; ++k) {
        if (file_.sway[k].joint == name) at.Fail("joint \"" + name + "\" is named twice; expected one entry for each");
      }
    }
    robot_.walk_ratio_m_s = file_.walk_ratio_m_s;
    robot_.sway = file_.sway;
  }

  RobotMount ReadMount(const std::string& key, const MountFile& file) const {
    const OptionValue mount = Required(root_, key, "{link: NAME, position: [x, y, z], rpy_deg: [r, p, y]}");
    const OptionValue link = Required(mount, "link", "the link that carries it");
    const Eigen::Vector3d rpy = file.rpy_deg * std::numbers::pi / 180;
    return {Find(link, file.link, robot_.links, "link"),
            Pose(Eigen::Matrix3d(RotZ(rpy.z()) * RotY(rpy.y()) * RotX(rpy.x())), file.position)};
  }

  OptionValue root_;
  RobotFile file_;
  Robot robot_;
};

template <class Elements>
int IndexOf(const Elements& elements, const std::string& name) {
  for (size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].name == name) return int(i);
  }
  return -1;
}

}  // namespace

int Robot::FindLink(const std::string& name) const { return IndexOf(links, name); }
int Robot::FindJoint(const std::string& name) const { return IndexOf(joints, name); }

double Robot::TotalMass() const {
  double sum = 0;
  for (const RobotLink& link : links) sum += link.mass_kg;
  return sum;
}

std::vector<Pose> LinkPoses(const Robot& robot, const std::vector<double>& joint_positions) {
  GAITCAM_ASSERT(joint_positions.size() == robot.joints.size());
  std::vector<Pose> poses(robot.links.size());
  for (size_t i = 0; i < robot.joints.size(); ++i) {
    const RobotJoint& joint = robot.joints[i];
    Pose X_JC;  // moved by the joint's position
    if (joint.kind == RobotJoint::Kind::kPrismatic) {
      X_JC.translation = joint.axis * joint_positions[i];
    } else if (joint.kind != RobotJoint::Kind::kFixed) {
      X_JC.rotation = Eigen::AngleAxisd(joint_positions[i], joint.axis);
    }
    poses[joint.child_link] = poses[joint.parent_link] * joint.X_PJ * X_JC;
  }
  return poses;
}

std::vector<std::string> ListRobots(const std::filesystem::path& models_folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(models_folder / "robots", ignored)) {
    const std::string name = entry.path().filename().string();
    if (std::filesystem::is_regular_file(entry.path() / (name + ".yaml"))) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

Robot ReadRobot(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const std::filesystem::path shipped = models_folder / "robots" / name_or_path / (name_or_path + ".yaml");
  if (name_or_path.find('/') == std::string::npos && IsFile(shipped)) {
    return RobotBuilder(shipped).Build();
  }
  const std::filesystem::path path(name_or_path);
  if (path.extension() == ".yaml" || path.extension() == ".yml") return RobotBuilder(path).Build();
  const std::vector<std::string> names = ListRobots(models_folder);
  throw BadInput(fmt::format(
      "robot \"{}\" is unknown; {}", name_or_path,
      DidYouMean(name_or_path, names, "expected one of " + JoinWords(names) + " or the path of a .yaml file")));
}

}  // namespace gaitcam
