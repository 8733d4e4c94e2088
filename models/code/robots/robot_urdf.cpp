#include "models/code/robots/robot_urdf.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <cstring>
#include <mutex>
#include <numbers>
#include <set>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/core/file_names.h"

namespace gaitcam {
namespace {

/// urdfdom reports errors on the console; here the first one is kept for the exception.
class QuietConsole : public console_bridge::OutputHandler {
 public:
  QuietConsole() : lock_(Mutex()) { console_bridge::useOutputHandler(this); }
  ~QuietConsole() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error_.empty()) first_error_ = text;
  }
  const std::string& first_error() const { return first_error_; }

 private:
  static std::mutex& Mutex() {
    static std::mutex mutex;  // guards console_bridge's own global, the one output handler of the process
    return mutex;
  }
  std::lock_guard<std::mutex> lock_;
  std::string first_error_;
};

/// Reads one URDF file: first its structure by tinyxml2, so that errors name a line, then its values by urdfdom.
class UrdfReader {
 public:
  UrdfReader(const std::filesystem::path& file, const std::map<std::string, double>& masses)
      : file_(file), masses_(masses) {}

  UrdfTree Read() {
    LoadXml();
    FindElements();
    CheckForFormats(document_.RootElement());
    const std::string root = FindRoot();
    for (const auto& [name, element] : joint_elements_) CheckJoint(name, element);
    ParseValues();
    AddLink(root, -1);
    for (const auto& [name, element] : link_elements_) {
      if (!seen_links_.count(name))
        Fail(element, "link \"" + name + "\" cannot be reached from root link \"" + root + "\"");
    }
    CheckMasses();
    return std::move(tree_);
  }

 private:
  using Element = const tinyxml2::XMLElement*;

  [[noreturn]] void Fail(Element element, const std::string& message) const {
    throw BadInput(fmt::format("{}:{}: {}", file_.string(), element->GetLineNum(), message));
  }

  void LoadXml() {
    text_ = FileContent(file_);
    document_.Parse(text_.c_str());
    if (document_.Error()) {
      throw BadInput(
          fmt::format("{}:{}: not valid XML: {}", file_.string(), document_.ErrorLineNum(), document_.ErrorName()));
    }
    if (!document_.RootElement() || document_.RootElement()->Name() != std::string("robot")) {
      throw BadInput(file_.string() + ": expected a URDF file with root element <robot>");
    }
  }

  /// urdfdom puts attributes into its messages and hands these to printf as formats, so that "%n" writes to memory. It
  /// reads links, joints and materials alone; other elements, as a simulator's, may hold what they like.
  void CheckForFormats(Element element) const {
    for (auto* attribute = element->FirstAttribute(); attribute; attribute = attribute->Next()) {
      if (std::strchr(attribute->Value(), '%'))
        Fail(element, fmt::format("{} \"{}\"; expected a value without %", attribute->Name(), attribute->Value()));
    }
    for (Element child = element->FirstChildElement(); child; child = child->NextSiblingElement()) {
      const std::string kind = child->Name();
      if (element != document_.RootElement() || kind == "link" || kind == "joint" || kind == "material")
        CheckForFormats(child);
    }
  }

  std::string Attribute(Element element, const char* key, const std::string& what) const {
    const char* value = element->Attribute(key);
    if (!value || !*value) Fail(element, what + ": expected attribute " + key);
    return value;
  }

  void FindElements() {
    for (Element e = document_.RootElement()->FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string kind = e->Name();
      if (kind != "link" && kind != "joint") continue;
      const std::string name = Attribute(e, "name", kind);
      auto& elements = kind == "link" ? link_elements_ : joint_elements_;
      for (const auto& [other, first] : elements) {
        if (other == name)
          Fail(e, fmt::format("{} \"{}\" is given twice, first in line {}", kind, name, first->GetLineNum()));
      }
      elements.emplace_back(name, e);
    }
    if (link_elements_.empty()) throw BadInput(file_.string() + ": expected at least one <link>");
  }

  std::vector<std::string> LinkNames() const {
    std::vector<std::string> names;
    for (const auto& [name, element] : link_elements_) names.push_back(name);
    return names;
  }

  std::string LinkOfJoint(const std::string& joint, Element element, const char* end) const {
    const std::string what = "joint \"" + joint + "\"";
    Element child = element->FirstChildElement(end);
    if (!child) Fail(element, fmt::format("{}: expected <{} link=\"...\"/>", what, end));
    std::string link = Attribute(child, "link", what + ": " + end);
    const std::vector<std::string> names = LinkNames();
    if (std::find(names.begin(), names.end(), link) == names.end()) {
      Fail(child, fmt::format("{}: {} link \"{}\" does not exist; {}", what, end, link,
                              DidYouMean(link, names, "expected the name of a <link>")));
    }
    return link;
  }

  std::string FindRoot() const {
    std::map<std::string, std::string> joint_to;
    for (const auto& [name, element] : joint_elements_) {
      LinkOfJoint(name, element, "parent");
      const std::string child = LinkOfJoint(name, element, "child");
      if (!joint_to.emplace(child, name).second) {
        Fail(element, fmt::format("joint \"{}\": link \"{}\" already is the child of joint \"{}\"; expected one parent",
                                  name, child, joint_to[child]));
      }
    }
    std::string root;
    for (const auto& [name, element] : link_elements_) {
      if (joint_to.count(name)) continue;
      if (!root.empty()) {
        Fail(element,
             fmt::format("link \"{}\" is a second root beside \"{}\"; expected a joint that leads to it", name, root));
      }
      root = name;
    }
    if (root.empty())
      throw BadInput(file_.string() + ": the joints form a loop; expected one link that is no joint's child");
    return root;
  }

  void CheckJoint(const std::string& name, Element element) const {
    const std::string what = "joint \"" + name + "\"", type = Attribute(element, "type", what);
    const std::vector<std::string> known{"revolute", "continuous", "prismatic", "fixed"};
    if (std::find(known.begin(), known.end(), type) == known.end()) {
      Fail(element, what + ": type \"" + type + "\"; expected revolute, continuous, prismatic or fixed");
    }
    if (type == "fixed") return;
    if (!element->FirstChildElement("axis")) Fail(element, what + ": expected <axis xyz=\"...\"/>");
    Element limit = element->FirstChildElement("limit");
    if (type != "continuous" && (!limit || !limit->Attribute("lower") || !limit->Attribute("upper"))) {
      Fail(element, what + ": expected <limit> with lower and upper");
    }
  }

  void ParseValues() {
    QuietConsole console;
    try {
      model_ = urdf::parseURDF(text_);
    } catch (const std::exception& e) {
      throw BadInput(file_.string() + ": " + e.what());
    }
    if (!model_ || !console.first_error().empty()) {
      throw BadInput(file_.string() + ": " +
                     (console.first_error().empty() ? "not a URDF model" : console.first_error()));
    }
    for (const auto& [name, element] : link_elements_) CheckName(model_->getLink(name) != nullptr, name, element);
    for (const auto& [name, element] : joint_elements_) CheckName(model_->getJoint(name) != nullptr, name, element);
  }

  /// urdfdom's XML reader and tinyxml2 may take one name for two, as with a stray &. @param is_there in urdfdom's model
  void CheckName(bool is_there, const std::string& name, Element element) const {
    if (is_there) return;
    Fail(element, fmt::format("{} \"{}\": urdfdom reads another name; expected plain characters, and &amp; for &",
                              element->Name(), name));
  }

  Element ElementOf(const std::vector<std::pair<std::string, Element>>& elements, const std::string& name) const {
    for (const auto& [other, element] : elements) {
      if (other == name) return element;
    }
    return document_.RootElement();
  }

  static Pose ToPose(const urdf::Pose& p) {
    return {Eigen::Quaterniond(p.rotation.w, p.rotation.x, p.rotation.y, p.rotation.z),
            Eigen::Vector3d(p.position.x, p.position.y, p.position.z)};
  }

  void AddLink(const std::string& name, int parent_joint) {
    const urdf::LinkConstSharedPtr source = model_->getLink(name);
    Element element = ElementOf(link_elements_, name);
    RobotLink link;
    link.name = name;
    for (const auto& v : source->visual_array) {
      link.visuals.push_back(ToShape(*v->geometry, v->origin, element, name));
      if (v->material) {
        const urdf::Color& c = v->material->color;
        if (c.a > 0) link.visuals.back().rgba = {c.r, c.g, c.b, c.a};
      }
    }
    for (const auto& c : source->collision_array)
      link.collisions.push_back(ToShape(*c->geometry, c->origin, element, name));
    ReadInertia(*source, element, link);
    const int index = int(tree_.links.size());
    tree_.links.push_back(std::move(link));
    seen_links_.insert(name);
    if (parent_joint >= 0) tree_.joints[parent_joint].child_link = index;
    for (const auto& [joint_name, joint_element] : joint_elements_) {
      const urdf::JointConstSharedPtr joint = model_->getJoint(joint_name);
      if (joint->parent_link_name != name) continue;
      const int joint_index = AddJoint(*joint, joint_element, index);
      AddLink(joint->child_link_name, joint_index);
    }
  }

  int AddJoint(const urdf::Joint& source, Element element, int parent_link) {
    RobotJoint joint;
    joint.name = source.name;
    joint.parent_link = parent_link;
    joint.X_PJ = ToPose(source.parent_to_joint_origin_transform);
    switch (source.type) {
      case urdf::Joint::REVOLUTE: joint.kind = RobotJoint::Kind::kRevolute; break;
      case urdf::Joint::CONTINUOUS: joint.kind = RobotJoint::Kind::kContinuous; break;
      case urdf::Joint::PRISMATIC: joint.kind = RobotJoint::Kind::kPrismatic; break;
      default: joint.kind = RobotJoint::Kind::kFixed; break;
    }
    const std::string what = "joint \"" + joint.name + "\"";
    if (joint.kind != RobotJoint::Kind::kFixed) {
      joint.axis = {source.axis.x, source.axis.y, source.axis.z};
      if (!(joint.axis.norm() > 1e-6))
        Fail(element, what + ": the axis has no direction; expected a vector other than 0 0 0");
      joint.axis.normalize();
    }
    if (source.limits && joint.kind != RobotJoint::Kind::kContinuous) {
      joint.lower = source.limits->lower;
      joint.upper = source.limits->upper;
      if (joint.kind != RobotJoint::Kind::kFixed && !(joint.lower < joint.upper)) {
        Fail(element, fmt::format("{}: limits {} to {}; expected lower < upper", what, joint.lower, joint.upper));
      }
    }
    tree_.efforts.push_back(source.limits ? source.limits->effort : 0);
    tree_.joints.push_back(joint);
    return int(tree_.joints.size()) - 1;
  }

  RobotShape ToShape(const urdf::Geometry& geometry, const urdf::Pose& origin, Element element,
                     const std::string& link) const {
    RobotShape shape;
    shape.X_LS = ToPose(origin);
    if (geometry.type == urdf::Geometry::BOX) {
      const auto& box = static_cast<const urdf::Box&>(geometry);
      shape.kind = RobotShape::Kind::kBox;
      shape.size = {box.dim.x, box.dim.y, box.dim.z};
      if (!(shape.size.minCoeff() > 0)) Fail(element, "link \"" + link + "\": a box has an edge of 0; expected more");
    } else if (geometry.type == urdf::Geometry::CYLINDER) {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
      shape.kind = RobotShape::Kind::kCylinder;
      shape.size = {cylinder.radius, cylinder.length, 0};
      if (!(shape.size.head<2>().minCoeff() > 0)) {
        Fail(element, "link \"" + link + "\": a cylinder has radius or length 0; expected more");
      }
    } else if (geometry.type == urdf::Geometry::SPHERE) {
      shape.kind = RobotShape::Kind::kSphere;
      shape.size = {static_cast<const urdf::Sphere&>(geometry).radius, 0, 0};
      if (!(shape.size.x() > 0)) Fail(element, "link \"" + link + "\": a sphere has radius 0; expected more");
    } else {
      const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
      shape.kind = RobotShape::Kind::kMesh;
      shape.size = {mesh.scale.x, mesh.scale.y, mesh.scale.z};
      shape.mesh = FindMesh(mesh.filename, element, link);
    }
    return shape;
  }

  /// `package://NAME/a/b` is searched for as `a/b` in the URDF's folder and its parents, up to one called NAME.
  std::filesystem::path FindMesh(const std::string& name, Element element, const std::string& link) const {
    const std::filesystem::path folder = std::filesystem::absolute(file_).parent_path();
    std::filesystem::path found;
    if (name.rfind("package://", 0) == 0) {
      const std::string rest = name.substr(10), inside = rest.substr(std::min(rest.size(), rest.find('/') + 1));
      for (auto at = folder; found.empty() && at != at.root_path(); at = at.parent_path()) {
        if (IsFile(at / inside)) found = at / inside;
        if (at.filename() == rest.substr(0, rest.find('/'))) break;
      }
      if (found.empty()) found = folder / inside;
    } else {
      found = folder / (name.rfind("file://", 0) == 0 ? name.substr(7) : name);
    }
    const std::string what = "link \"" + link + "\": mesh \"" + name + "\"";
    if (!IsFile(found)) Fail(element, what + " is not there; expected a file " + found.string());
    std::string extension = found.extension().string();
    for (char& c : extension) c = char(std::tolower(c));
    if (extension != ".stl" && extension != ".obj") Fail(element, what + ": expected a file of type .stl or .obj");
    return found;
  }

  void ReadInertia(const urdf::Link& source, Element element, RobotLink& link) const {
    const auto given = masses_.find(link.name);
    if (!source.inertial) {
      if (given != masses_.end()) InertiaOfShapes(given->second, element, link);
      return;
    }
    const std::string what = "link \"" + link.name + "\"";
    if (given != masses_.end())
      Fail(element, what + " has an <inertial> already; expected no mass for it in the YAML file");
    const urdf::Inertial& i = *source.inertial;
    if (!(i.mass > 0)) Fail(element, fmt::format("{}: mass {} kg; expected more than 0", what, i.mass));
    Eigen::Matrix3d inertia;
    inertia << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
    const Eigen::Vector3d p = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
    // Principal moments of a body obey a + b >= c. The slack allows for numbers printed with four digits.
    if (!(p[0] > 0) || p[0] + p[1] < p[2] * (1 - 1e-3)) {
      Fail(element, fmt::format("{}: inertia with principal moments {:.4g}, {:.4g}, {:.4g} kg m^2 belongs to no body; "
                                "expected all above 0 and none above the sum of the others",
                                what, p[0], p[1], p[2]));
    }
    const Pose X_LI = ToPose(i.origin);
    link.mass_kg = i.mass;
    link.com = X_LI.translation;
    link.inertia = X_LI.R() * inertia * X_LI.R().transpose();
  }

  /// Inertia of shapes filled with one density, about their common centre of mass.
  void InertiaOfShapes(double mass_kg, Element element, RobotLink& link) const {
    const std::string what = "link \"" + link.name + "\"";
    const auto& shapes = link.collisions.empty() ? link.visuals : link.collisions;
    double volume = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (const RobotShape& shape : shapes) {
      if (shape.kind == RobotShape::Kind::kMesh)
        Fail(element, what + ": expected <inertial>, as it cannot be derived from a mesh");
      volume += Volume(shape);
      moment += Volume(shape) * shape.X_LS.translation;
    }
    if (shapes.empty()) Fail(element, what + ": expected <inertial>, or a shape to derive the inertia from");
    link.mass_kg = mass_kg;
    link.com = moment / volume;
    for (const RobotShape& shape : shapes) {
      const double m = mass_kg * Volume(shape) / volume;
      const Eigen::Vector3d d = shape.X_LS.translation - link.com;
      link.inertia += shape.X_LS.R() * UnitInertia(shape) * shape.X_LS.R().transpose() * m;
      link.inertia += m * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
    }
  }

  static double Volume(const RobotShape& s) {
    using std::numbers::pi;
    if (s.kind == RobotShape::Kind::kBox) return s.size.prod();
    if (s.kind == RobotShape::Kind::kCylinder) return pi * s.size[0] * s.size[0] * s.size[1];
    return 4.0 / 3.0 * pi * std::pow(s.size[0], 3);
  }

  /// Per kg, about the shape's own centre.
  static Eigen::Matrix3d UnitInertia(const RobotShape& s) {
    Eigen::Vector3d d;
    const double a = s.size[0] * s.size[0], b = s.size[1] * s.size[1], c = s.size[2] * s.size[2];
    if (s.kind == RobotShape::Kind::kBox) {
      d = Eigen::Vector3d(b + c, a + c, a + b) / 12;
    } else if (s.kind == RobotShape::Kind::kCylinder) {
      d = Eigen::Vector3d((3 * a + b) / 12, (3 * a + b) / 12, a / 2);
    } else {
      d.setConstant(0.4 * a);
    }
    return d.asDiagonal();
  }

  /// A moving link needs mass, its own or that of a link fixed to it.
  void CheckMasses() const {
    std::vector<double> mass(tree_.links.size());
    for (size_t i = 0; i < mass.size(); ++i) mass[i] = tree_.links[i].mass_kg;
    for (size_t j = tree_.joints.size(); j-- > 0;) {
      const RobotJoint& joint = tree_.joints[j];
      if (joint.kind == RobotJoint::Kind::kFixed) mass[joint.parent_link] += mass[joint.child_link];
    }
    for (size_t i = 0; i < mass.size(); ++i) {
      if (mass[i] > 0 || (i > 0 && tree_.joints[i - 1].kind == RobotJoint::Kind::kFixed)) continue;
      Fail(ElementOf(link_elements_, tree_.links[i].name),
           "link \"" + tree_.links[i].name +
               "\" moves but has no mass; expected <inertial>, or its mass under masses in the YAML file");
    }
    for (const auto& [name, kg] : masses_) {
      if (!seen_links_.count(name))
        throw BadInput(file_.string() + ": no link \"" + name + "\", whose mass the YAML file gives");
    }
  }

  std::filesystem::path file_;
  const std::map<std::string, double>& masses_;
  std::string text_;
  tinyxml2::XMLDocument document_;
  std::vector<std::pair<std::string, Element>> link_elements_, joint_elements_;
  urdf::ModelInterfaceSharedPtr model_;
  UrdfTree tree_;
  std::set<std::string> seen_links_;
};

}  // namespace

UrdfTree ReadUrdf(const std::filesystem::path& file, const std::map<std::string, double>& masses) {
  return UrdfReader(file, masses).Read();
}

}  // namespace gaitcam
