#include <fmt/format.h>
#include <tinyxml2.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "models/code/people/person_shape.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

/// Numbers are written with as many digits as read back the same.
template <class Vector>
std::string Text(const Vector& v) {
  std::string text;
  for (int i = 0; i < int(v.size()); ++i) text += fmt::format("{}{}", i ? " " : "", v[i]);
  return text;
}

using tinyxml2::XMLElement;
using Attributes = std::initializer_list<std::pair<const char*, std::string>>;

std::string Text(double value) { return fmt::format("{}", value); }

void Set(XMLElement* element, const Attributes& attributes) {
  for (const auto& [name, value] : attributes) element->SetAttribute(name, value.c_str());
}

/// Appends an element.
XMLElement* Add(XMLElement* parent, const char* name, const Attributes& attributes = {}) {
  XMLElement* element = parent->InsertNewChildElement(name);
  Set(element, attributes);
  return element;
}

void SetPose(XMLElement* element, const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  Set(element, {{"pos", Text(pose.translation)}, {"quat", fmt::format("{} {} {} {}", q.w(), q.x(), q.y(), q.z())}});
}

/// Collision bits: what belongs to the scene meets what belongs to the robot, and nothing else.
enum class Collides { kAsScene, kAsRobot, kNever };

void SetCollision(XMLElement* geom, Collides collides) {
  geom->SetAttribute("contype", collides == Collides::kAsScene ? 1 : collides == Collides::kAsRobot ? 2 : 0);
  geom->SetAttribute("conaffinity", collides == Collides::kAsScene ? 2 : collides == Collides::kAsRobot ? 1 : 0);
}

/// Textured surfaces are meshes, because only these take texture coordinates.
class TexturedMesh {
 public:
  /// Adds a face from its lower left corner along `right` (width) and `up` (height). The image spans `repeat`, starting
  /// at the lower left corner. Faces are cut into cells, as MuJoCo lights corners only.
  void AddFace(const Eigen::Vector3d& corner, const Eigen::Vector3d& right, const Eigen::Vector3d& up,
               const Eigen::Vector2d& repeat) {
    const int nx = Cells(right.norm()), ny = Cells(up.norm()), first = vertices_;
    for (int y = 0; y <= ny; ++y) {
      for (int x = 0; x <= nx; ++x) {
        const double a = double(x) / nx, b = double(y) / ny;
        vertex_ += Text(Eigen::Vector3d(corner + a * right + b * up)) + " ";
        normal_ += Text(Eigen::Vector3d(right.cross(up).normalized())) + " ";
        // MuJoCo's image rows run against the texture coordinate: row 0 (top) is at v = 0.
        texcoord_ += fmt::format("{} {} ", a * right.norm() / repeat.x(), 1 - b * up.norm() / repeat.y());
        ++vertices_;
      }
    }
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const int i = first + y * (nx + 1) + x;
        face_ += fmt::format("{} {} {} {} {} {} ", i, i + 1, i + nx + 2, i, i + nx + 2, i + nx + 1);
      }
    }
  }

  /// All six faces of a box about the origin, as SceneBox says; `repeat` 0 stretches the image over each face.
  void AddBox(const Eigen::Vector3d& size, const Eigen::Vector2d& repeat) {
    for (int axis = 0; axis < 3; ++axis) {
      for (double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d normal = sign * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector3d up = axis == 2 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d right = up.cross(normal);
        const Eigen::Vector3d w = right * std::abs(right.dot(size)), h = up * std::abs(up.dot(size));
        const Eigen::Vector2d span = repeat.minCoeff() > 0 ? repeat : Eigen::Vector2d(w.norm(), h.norm());
        AddFace(0.5 * (std::abs(normal.dot(size)) * normal - w - h), w, h, span);
      }
    }
  }

  void AddTo(XMLElement* assets, const std::string& name) const {
    Add(assets, "mesh",
        {{"name", name}, {"vertex", vertex_}, {"normal", normal_}, {"texcoord", texcoord_}, {"face", face_}});
  }

 private:
  static int Cells(double length_m) { return std::clamp(int(std::ceil(length_m / 0.5)), 1, 60); }

  std::string vertex_, normal_, texcoord_, face_;
  int vertices_ = 0;
};

/// Writes the MJCF of one scene and one robot.
class MjcfWriter {
 public:
  MjcfWriter(const Robot& robot, const Scene& scene, const PhysicsOptions& physics,
             const std::vector<WorldCamera>& cameras)
      : robot_(robot), scene_(scene), physics_(physics), cameras_(cameras) {}

  MjcfBundle Write() {
    WriteGlobals();
    assets_ = Add(root_, "asset");
    bodies_ = Add(root_, "worldbody");
    scenery_ = document_.NewElement("body");
    scenery_->SetAttribute("name", "scenery");
    WriteFloor();
    for (size_t i = 0; i < scene_.boxes.size(); ++i) WriteBox(int(i));
    for (const SceneLight& light : scene_.lights) WriteLight(light);
    int group = 0;
    for (const auto& [where, body] : neighbours_) {
      body->SetAttribute("name", fmt::format("boxes{}", group++).c_str());
      bodies_->InsertEndChild(body);
    }
    bodies_->InsertEndChild(scenery_);
    WriteBody(0, bodies_);
    for (size_t i = 0; i < scene_.people.size(); ++i) WritePerson(int(i));
    actuators_ = Add(root_, "actuator");
    WriteActuators();
    XMLElement* sensors = Add(root_, "sensor");
    Add(sensors, "gyro", {{"name", "gyro"}, {"site", "imu"}});
    Add(sensors, "accelerometer", {{"name", "accelerometer"}, {"site", "imu"}});
    tinyxml2::XMLPrinter printer;
    document_.Print(&printer);
    bundle_.xml = printer.CStr();
    return std::move(bundle_);
  }

 private:
  void WriteGlobals() {
    root_ = document_.NewElement("mujoco");
    root_->SetAttribute("model", robot_.name.c_str());
    document_.InsertEndChild(root_);
    Add(root_, "compiler", {{"angle", "radian"}, {"autolimits", "true"}});
    XMLElement* size = Add(root_, "size", {{"njmax", "800"}, {"nconmax", "150"}});
    if (!scene_.people.empty()) Set(size, {{"nuser_geom", std::to_string(kCoreNumbers)}});
    Add(root_, "option",
        {{"timestep", Text(physics_.timestep_ms * 1e-3)},
         {"integrator", "Euler"},
         {"solver", "Newton"},
         {"iterations", "50"},
         {"tolerance", "1e-10"},
         {"cone", "elliptic"},
         {"impratio", "3"}});
    WriteVisual();
    Add(Add(root_, "default"), "geom",
        {{"solref", "0.008 1"}, {"solimp", "0.95 0.99 0.001"}, {"friction", "0.8 0.005 0.0001"}, {"condim", "4"}});
  }

  void WriteVisual() {
    const double extent = 0.5 * (scene_.floor_max - scene_.floor_min).norm();
    XMLElement* visual = Add(root_, "visual");
    Add(visual, "headlight",
        {{"ambient", Text(Eigen::Vector3d(scene_.ambient * scene_.ambient_rgb))},
         {"diffuse", "0 0 0"},
         {"specular", "0 0 0"}});
    Add(visual, "map",
        {{"znear", "0.01"},
         {"zfar", "60"},
         {"shadowclip", Text(std::clamp(extent, 1.0, 12.0))},
         {"shadowscale", "0.9"}});
    Add(visual, "global", {{"offwidth", "1920"}, {"offheight", "1440"}});
    Add(visual, "quality", {{"shadowsize", "2048"}, {"offsamples", "4"}});
    Add(root_, "statistic", {{"extent", "1"}, {"center", "0 0 0.2"}});
  }

  void AddFile(const std::string& name, std::vector<unsigned char> bytes) {
    bundle_.files.emplace_back(name, std::move(bytes));
  }

  /// @returns the material that shows a texture of the scene.
  std::string TextureMaterial(int texture) {
    GAITCAM_ASSERT(texture >= 0 && texture < int(scene_.textures.size()));
    std::string name = fmt::format("tex{}", texture);
    if (!written_textures_.insert(texture).second) return name;
    // mjrContext holds 100 textures, the sky among them, and says nothing about more.
    if (written_textures_.size() > 99) {
      throw BadInput(scene_.file.string() + ": more than 99 textures; MuJoCo cannot draw so many");
    }
    bundle_.pictures.push_back({name, scene_.textures[texture].make});
    Add(assets_, "texture", {{"name", name}, {"type", "2d"}, {"builtin", "flat"}, {"width", "1"}, {"height", "1"}});
    Add(assets_, "material",
        {{"name", name}, {"texture", name}, {"specular", "0"}, {"shininess", "0"}, {"reflectance", "0"}});
    return name;
  }

  /// The floor collides as an infinite plane; its textured extent is a mesh for display only.
  void WriteFloor() {
    const std::string sky = Text(Eigen::Vector3d(scene_.background_rgb));
    Add(assets_, "texture",
        {{"type", "skybox"}, {"builtin", "flat"}, {"rgb1", sky}, {"rgb2", sky}, {"width", "32"}, {"height", "192"}});
    Add(assets_, "material", {{"name", "matte"}, {"specular", "0.1"}, {"shininess", "0.2"}, {"reflectance", "0"}});
    const Eigen::Vector2d center = 0.5 * (scene_.floor_min + scene_.floor_max),
                          size = scene_.floor_max - scene_.floor_min;
    const bool textured = scene_.floor_texture >= 0;
    XMLElement* floor = Add(bodies_, "geom",
                            {{"name", "floor"},
                             {"type", "plane"},
                             {"pos", Text(center) + " 0"},
                             {"size", Text(Eigen::Vector2d(0.5 * size)) + " 1"},
                             {"material", "matte"},
                             {"rgba", ".6 .6 .6 1"},
                             {"friction", SceneFriction()},
                             {"priority", "1"},
                             {"group", textured ? "3" : "0"}});
    SetCollision(floor, Collides::kAsScene);
    if (!textured) return;
    TexturedMesh mesh;  // a slab under z = 0, because MuJoCo wants meshes to have a volume
    const double depth = 0.01;
    mesh.AddFace({scene_.floor_min.x(), scene_.floor_min.y(), 0}, size.x() * Eigen::Vector3d::UnitX(),
                 size.y() * Eigen::Vector3d::UnitY(), scene_.floor_texture_size_m);
    mesh.AddFace({scene_.floor_min.x(), scene_.floor_max.y(), -depth}, size.x() * Eigen::Vector3d::UnitX(),
                 -size.y() * Eigen::Vector3d::UnitY(), size);
    mesh.AddTo(assets_, "floor");
    XMLElement* picture = Add(scenery_, "geom", {{"name", "floor_picture"}, {"type", "mesh"}, {"mesh", "floor"}});
    ShowTexture(picture, scene_.floor_texture);
  }

  /// What is only seen.
  void ShowTexture(XMLElement* geom, int texture) {
    Set(geom, {{"material", TextureMaterial(texture)}, {"group", "0"}});
    SetCollision(geom, Collides::kNever);
  }

  std::string SceneFriction() const { return fmt::format("{} 0.005 0.0001", scene_.floor_friction); }

  /// MuJoCo tests every geom of the world body against every geom of the robot; other bodies pass a broad phase whose
  /// cost grows with the square of their number. Colliding boxes are therefore grouped into a few bodies of neighbours,
  /// and geoms for display only are in the body `scenery`.
  void WriteBox(int index) {
    const SceneBox& box = scene_.boxes[index];
    const bool textured = box.texture >= 0;
    if (!textured || box.collides) {
      XMLElement* geom = Add(box.collides ? Neighbours(box, index) : scenery_, "geom",
                             {{"name", fmt::format("box{}", index)}, {"type", "box"}});
      SetPose(geom, box.X_WB);
      Set(geom, {{"size", Text(Eigen::Vector3d(0.5 * box.size))},
                 {"material", "matte"},
                 {"rgba", Text(box.rgb) + " 1"},
                 {"friction", SceneFriction()},
                 {"priority", "1"},
                 {"group", textured ? "3" : "0"}});
      SetCollision(geom, box.collides ? Collides::kAsScene : Collides::kNever);
    }
    if (!textured) return;
    TexturedMesh mesh;
    mesh.AddBox(box.size, box.texture_size_m);
    const std::string name = fmt::format("box{}_picture", index);
    mesh.AddTo(assets_, name);
    XMLElement* picture = Add(scenery_, "geom", {{"name", name}, {"type", "mesh"}, {"mesh", name}});
    SetPose(picture, box.X_WB);
    ShowTexture(picture, box.texture);
  }

  /// The body of boxes whose centres are in the same square of 2 m.
  XMLElement* Neighbours(const SceneBox& box, int index) {
    XMLElement*& body = neighbours_[Neighbourhood(box, index)];
    if (!body) body = document_.NewElement("body");
    return body;
  }

  /// A large box is a group of its own, so as not to enlarge the extent of another.
  static std::array<int, 3> Neighbourhood(const SceneBox& box, int index) {
    const double side_m = 2;
    const Eigen::Vector3d extent = box.X_WB.R().cwiseAbs() * box.size;
    if (extent.head<2>().maxCoeff() > side_m) return {0, 0, index + 1};
    const Eigen::Vector3d& p = box.X_WB.translation;
    return {int(std::floor(p.x() / side_m)), int(std::floor(p.y() / side_m)), 0};
  }

  /// Mocap bodies without mass or contact, so that people do not affect the robot. They follow the robot's bodies,
  /// whose numbers thus do not depend on people.
  void WritePerson(int index) {
    std::array<XMLElement*, kPersonParts> bodies;
    for (int part = 0; part < kPersonParts; ++part) {
      const std::string name = fmt::format("person{}.{}", index, PersonPartName(PersonPart(part)));
      bodies[size_t(part)] = Add(bodies_, "body", {{"name", name}, {"mocap", "true"}});
      AddNoInertia(bodies[size_t(part)]);
    }
    const std::vector<PersonSurface> surfaces = PersonSurfaces(scene_.people[index], scene_.cloth_size_m);
    for (size_t i = 0; i < surfaces.size(); ++i) {
      const PersonSurface& surface = surfaces[i];
      const std::string mesh = fmt::format("person{}_{}", index, i);
      AddSurfaceMesh(mesh, surface);
      const std::string material = surface.cloth ? TextureMaterial(scene_.cloth_texture) : "matte";
      const Eigen::Vector3d rgb = surface.cloth ? ClothColor(surface.rgb) : surface.rgb;
      XMLElement* geom =
          Add(bodies[size_t(surface.part)], "geom",
              {{"type", "mesh"}, {"mesh", mesh}, {"material", material}, {"rgba", Text(rgb) + " 1"}, {"group", "0"}});
      SetCollision(geom, Collides::kNever);
      std::string core;
      for (const SolidCore::Disc& end : surface.core.ends) {
        for (const Eigen::Vector3d& v : {end.center, end.a, end.b}) core += (core.empty() ? "" : " ") + Text(v);
      }
      Set(geom, {{"user", core}});
    }
  }

  void AddSurfaceMesh(const std::string& name, const PersonSurface& surface) {
    std::string vertex, normal, texcoord, face;
    for (size_t i = 0; i < surface.vertices.size(); ++i) {
      vertex += Text(surface.vertices[i]) + " ";
      normal += Text(surface.normals[i]) + " ";
      texcoord += Text(surface.texcoords[i]) + " ";
    }
    for (const std::array<int, 3>& f : surface.faces) face += fmt::format("{} {} {} ", f[0], f[1], f[2]);
    Add(assets_, "mesh",
        {{"name", name}, {"vertex", vertex}, {"normal", normal}, {"texcoord", texcoord}, {"face", face}});
  }

  /// The cloth's picture is a light grey that the colour is multiplied with.
  Eigen::Vector3d ClothColor(const Eigen::Vector3d& rgb) {
    if (!cloth_mean_) {  // to make the picture takes longer than to write a person
      const cv::Scalar mean = cv::mean(scene_.textures[scene_.cloth_texture].Bgr()) / 255;
      cloth_mean_ = Eigen::Array3d(mean[2], mean[1], mean[0]).max(0.1);
    }
    return (rgb.array() / *cloth_mean_).min(1.0);
  }

  void WriteLight(const SceneLight& light) {
    Add(bodies_, "light",
        {{"pos", Text(light.position)},
         {"dir", Text(light.direction)},
         {"directional", light.directional ? "true" : "false"},
         {"castshadow", light.casts_shadow ? "true" : "false"},
         {"diffuse", Text(Eigen::Vector3d(light.brightness * light.rgb))},
         {"specular", ".1 .1 .1"},
         {"ambient", "0 0 0"},
         {"cutoff", "85"},
         {"exponent", "1"}});
  }

  void WriteBody(int link_index, XMLElement* parent) {
    const RobotLink& link = robot_.links[link_index];
    Pose X_PB(Eigen::Quaterniond::Identity(), {0, 0, robot_.base_height_m});
    if (link_index > 0) X_PB = robot_.joints[link_index - 1].X_PJ;
    XMLElement* body = Add(parent, "body", {{"name", link.name}});
    SetPose(body, X_PB);
    if (link_index == 0) {
      WriteRootJoints(body);
    } else {
      WriteJoint(link_index - 1, body);
    }
    WriteInertia(link, body);
    const bool shows_collisions = link.visuals.empty();
    for (const RobotShape& shape : link.visuals) WriteShape(shape, 1, Collides::kNever, body);
    for (const RobotShape& shape : link.collisions) {
      WriteShape(shape, shows_collisions ? 1 : 3, Collides::kAsRobot, body);
    }
    WriteMounts(link_index, body);
    for (const RobotJoint& joint : robot_.joints) {
      if (joint.parent_link == link_index) WriteBody(joint.child_link, body);
    }
  }

  void WriteRootJoints(XMLElement* body) {
    if (robot_.kind == Robot::Kind::kHumanoid) {
      Add(body, "freejoint", {{"name", "root"}});
      return;
    }
    Add(body, "joint", {{"name", "drive_x"}, {"type", "slide"}, {"axis", "1 0 0"}});
    Add(body, "joint", {{"name", "drive_y"}, {"type", "slide"}, {"axis", "0 1 0"}});
    Add(body, "joint", {{"name", "drive_yaw"}, {"type", "hinge"}, {"axis", "0 0 1"}});
    Add(body, "joint", {{"name", "drive_pitch"}, {"type", "hinge"}, {"axis", "0 1 0"}});
    Add(body, "joint", {{"name", "drive_roll"}, {"type", "hinge"}, {"axis", "1 0 0"}});
  }

  void WriteJoint(int index, XMLElement* body) {
    const RobotJoint& joint = robot_.joints[index];
    if (joint.kind == RobotJoint::Kind::kFixed) return;
    const ServoOptions& servo = robot_.servos[index];
    const bool slides = joint.kind == RobotJoint::Kind::kPrismatic;
    XMLElement* element = Add(body, "joint",
                              {{"name", joint.name},
                               {"type", slides ? "slide" : "hinge"},
                               {"axis", Text(joint.axis)},
                               {"armature", Text(servo.armature)},
                               {"damping", Text(servo.damping)},
                               {"frictionloss", Text(servo.friction)}});
    if (joint.kind != RobotJoint::Kind::kContinuous) {
      element->SetAttribute("range", fmt::format("{} {}", joint.lower, joint.upper).c_str());
    }
  }

  /// Without it MuJoCo would weigh the shapes.
  static void AddNoInertia(XMLElement* body) {
    Add(body, "inertial", {{"pos", "0 0 0"}, {"mass", "0"}, {"diaginertia", "0 0 0"}});
  }

  void WriteInertia(const RobotLink& link, XMLElement* body) {
    if (!(link.mass_kg > 0)) {
      AddNoInertia(body);
      return;
    }
    const Eigen::Matrix3d& i = link.inertia;
    Add(body, "inertial",
        {{"pos", Text(link.com)},
         {"mass", Text(link.mass_kg)},
         {"fullinertia", fmt::format("{} {} {} {} {} {}", i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2))}});
  }

  void WriteShape(const RobotShape& shape, int group, Collides collides, XMLElement* body) {
    XMLElement* geom = Add(body, "geom");
    switch (shape.kind) {
      case RobotShape::Kind::kBox:
        Set(geom, {{"type", "box"}, {"size", Text(Eigen::Vector3d(0.5 * shape.size))}});
        break;
      case RobotShape::Kind::kCylinder:
        Set(geom, {{"type", "cylinder"}, {"size", fmt::format("{} {}", shape.size[0], 0.5 * shape.size[1])}});
        break;
      case RobotShape::Kind::kSphere: Set(geom, {{"type", "sphere"}, {"size", Text(shape.size[0])}}); break;
      case RobotShape::Kind::kMesh: Set(geom, {{"type", "mesh"}, {"mesh", MeshAsset(shape)}}); break;
    }
    SetPose(geom, shape.X_LS);
    Set(geom, {{"material", "matte"}, {"rgba", Text(shape.rgba)}, {"group", std::to_string(group)}});
    SetCollision(geom, collides);
  }

  std::string MeshAsset(const RobotShape& shape) {
    const std::string key = shape.mesh.string() + " " + Text(shape.size);
    const auto [found, is_new] = mesh_names_.emplace(key, fmt::format("mesh{}", mesh_names_.size()));
    if (!is_new) return found->second;
    std::string extension = shape.mesh.extension().string();
    for (char& c : extension) c = char(std::tolower(c));
    const std::string file = found->second + extension;
    const std::string bytes = FileContent(shape.mesh);
    AddFile(file, {bytes.begin(), bytes.end()});
    Add(assets_, "mesh", {{"name", found->second}, {"file", file}, {"scale", Text(shape.size)}});
    return found->second;
  }

  /// MuJoCo's cameras look along their -z with y up: the optical frame turned by pi about x.
  void WriteMounts(int link_index, XMLElement* body) {
    if (robot_.imu.link == link_index) {
      XMLElement* site = Add(body, "site", {{"name", "imu"}, {"size", ".002"}, {"group", "3"}});
      SetPose(site, robot_.imu.X_LS);
    }
    if (robot_.camera.link != link_index) return;
    const Pose X_CV(Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero());
    for (const WorldCamera& camera : cameras_) {
      XMLElement* element = Add(body, "camera", {{"name", camera.name}, {"fovy", "45"}});
      SetPose(element, robot_.camera.X_LS * camera.X_MC * X_CV);
    }
  }

  /// Force kp (control - position) - kv velocity.
  XMLElement* WriteServo(const std::string& name, const std::string& joint, double kp, double kv) {
    return Add(actuators_, "general",
               {{"name", name},
                {"joint", joint},
                {"biastype", "affine"},
                {"gainprm", Text(kp)},
                {"biasprm", fmt::format("0 {} {}", -kp, -kv)}});
  }

  void WriteActuators() {
    for (size_t i = 0; i < robot_.joints.size(); ++i) {
      if (robot_.joints[i].kind == RobotJoint::Kind::kFixed) continue;
      const ServoOptions& servo = robot_.servos[i];
      XMLElement* element = WriteServo("servo_" + robot_.joints[i].name, robot_.joints[i].name, servo.kp, servo.kv);
      element->SetAttribute("forcerange", fmt::format("{} {}", -servo.torque_limit, servo.torque_limit).c_str());
    }
    if (robot_.kind != Robot::Kind::kOmniBase) return;
    const double mass = robot_.TotalMass();
    const Eigen::Vector3d inertia = RootInertia();
    const DriveOptions& drive = robot_.drive;
    WriteOscillator("drive_x", mass, drive.frequency_hz, drive.damping_ratio);
    WriteOscillator("drive_y", mass, drive.frequency_hz, drive.damping_ratio);
    WriteOscillator("drive_yaw", inertia.z(), drive.frequency_hz, drive.damping_ratio);
    WriteOscillator("drive_pitch", inertia.y(), drive.rocking_hz, drive.rocking_damping_ratio);
    WriteOscillator("drive_roll", inertia.x(), drive.rocking_hz, drive.rocking_damping_ratio);
  }

  void WriteOscillator(const std::string& joint, double inertia, double frequency_hz, double damping_ratio) {
    const double omega = 2 * std::numbers::pi * frequency_hz;
    WriteServo(joint, joint, inertia * omega * omega, 2 * damping_ratio * inertia * omega);
  }

  /// Moments of inertia of the whole robot about the root's axes with all joints at zero, kg m^2.
  Eigen::Vector3d RootInertia() const {
    const std::vector<Pose> poses = LinkPoses(robot_, std::vector<double>(robot_.joints.size(), 0.0));
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (size_t i = 0; i < poses.size(); ++i) {
      const RobotLink& link = robot_.links[i];
      const Eigen::Vector3d p = poses[i] * link.com;
      sum += poses[i].R() * link.inertia * poses[i].R().transpose();
      sum += link.mass_kg * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
    }
    return sum.diagonal();
  }

  const Robot& robot_;
  const Scene& scene_;
  const PhysicsOptions& physics_;
  const std::vector<WorldCamera>& cameras_;
  MjcfBundle bundle_;
  tinyxml2::XMLDocument document_;  ///< Owns all elements.
  XMLElement *root_ = nullptr, *assets_ = nullptr, *bodies_ = nullptr, *scenery_ = nullptr, *actuators_ = nullptr;
  std::map<std::array<int, 3>, XMLElement*> neighbours_;
  std::set<int> written_textures_;
  std::map<std::string, std::string> mesh_names_;
  std::optional<Eigen::Array3d> cloth_mean_;  ///< RGB, of the picture of clothes, once it was asked for.
};

}  // namespace

MjcfBundle BuildMjcf(const Robot& robot, const Scene& scene, const PhysicsOptions& physics,
                     const std::vector<WorldCamera>& cameras) {
  return MjcfWriter(robot, scene, physics, cameras).Write();
}

}  // namespace gaitcam
