#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <set>

#include "algorithms/core/errors.h"
#include "models/person_shape.h"
#include "sim/world.h"

namespace gaitcam {
namespace {

/// Numbers are written with as many digits as read back the same.
template <class Vector>
std::string Text(const Vector& v) {
  std::string text;
  for (int i = 0; i < int(v.size()); ++i) text += fmt::format("{}{}", i ? " " : "", v[i]);
  return text;
}

std::string PoseText(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return fmt::format("pos='{}' quat='{} {} {} {}'", Text(pose.translation), q.w(), q.x(), q.y(), q.z());
}

std::string Escaped(const std::string& name) {
  std::string text;
  for (char c : name) {
    switch (c) {
      case '&': text += "&amp;"; break;
      case '<': text += "&lt;"; break;
      case '\'': text += "&apos;"; break;
      default: text += c;
    }
  }
  return text;
}

/// Collision bits: what belongs to the place meets what belongs to the robot, and nothing else.
constexpr const char* kPlaceCollides = "contype='1' conaffinity='2'";
constexpr const char* kRobotCollides = "contype='2' conaffinity='1'";
constexpr const char* kNoCollision = "contype='0' conaffinity='0'";

/// Surfaces with a texture are meshes, because only these let us say where on the image each corner lies.
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

  /// All six faces of a box about the origin, as PlaceBox says; `repeat` 0 stretches the image over each face.
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

  std::string ToXml(const std::string& name) const {
    return fmt::format("<mesh name='{}' vertex='{}' normal='{}' texcoord='{}' face='{}'/>\n", name, vertex_, normal_,
                       texcoord_, face_);
  }

 private:
  static int Cells(double length_m) { return std::clamp(int(std::ceil(length_m / 0.5)), 1, 60); }

  std::string vertex_, normal_, texcoord_, face_;
  int vertices_ = 0;
};

/// Writes the MJCF of one place and one robot.
class MjcfWriter {
 public:
  MjcfWriter(const Robot& robot, const Place& place, const PhysicsOptions& physics,
             const std::vector<WorldCamera>& cameras)
      : robot_(robot), place_(place), physics_(physics), cameras_(cameras) {}

  MjcfBundle Write() {
    WriteFloor();
    for (size_t i = 0; i < place_.boxes.size(); ++i) WriteBox(int(i));
    for (const PlaceLight& light : place_.lights) WriteLight(light);
    int group = 0;
    for (const auto& [where, geoms] : neighbours_) {
      bodies_ += fmt::format("<body name='boxes{}'>\n{}</body>\n", group++, geoms);
    }
    bodies_ += "<body name='scenery'>\n" + scenery_ + "</body>\n";
    WriteBody(0);
    for (size_t i = 0; i < place_.people.size(); ++i) WritePerson(int(i));
    WriteActuators();
    bundle_.xml = fmt::format(
        "<mujoco model='{}'>\n<compiler angle='radian' autolimits='true'/>\n<size njmax='800' nconmax='150'/>\n"
        "<option timestep='{}' integrator='Euler' solver='Newton' iterations='50' tolerance='1e-10' cone='elliptic' "
        "impratio='3'/>\n{}{}<asset>\n{}</asset>\n<worldbody>\n{}</worldbody>\n<actuator>\n{}</actuator>\n"
        "<sensor><gyro name='gyro' site='imu'/><accelerometer name='accelerometer' site='imu'/></sensor>\n</mujoco>\n",
        Escaped(robot_.name), physics_.timestep_ms * 1e-3, Visual(), kDefaults, assets_, bodies_, actuators_);
    return std::move(bundle_);
  }

 private:
  static constexpr const char* kDefaults =
      "<default><geom solref='0.008 1' solimp='0.95 0.99 0.001' friction='0.8 0.005 0.0001' condim='4'/></default>\n";

  std::string Visual() const {
    const double extent = 0.5 * (place_.floor_max - place_.floor_min).norm();
    return fmt::format(
        "<visual><headlight ambient='{} {} {}' diffuse='0 0 0' specular='0 0 0'/>"
        "<map znear='0.01' zfar='60' shadowclip='{}' shadowscale='0.9'/>"
        "<global offwidth='1920' offheight='1440'/><quality shadowsize='2048' offsamples='4'/></visual>\n"
        "<statistic extent='1' center='0 0 0.2'/>\n",
        place_.ambient * place_.ambient_rgb.x(), place_.ambient * place_.ambient_rgb.y(),
        place_.ambient * place_.ambient_rgb.z(), std::clamp(extent, 1.0, 12.0));
  }

  void AddFile(const std::string& name, std::vector<unsigned char> bytes) {
    bundle_.files.emplace_back(name, std::move(bytes));
  }

  /// @returns the material that shows a texture of the place.
  std::string TextureMaterial(int texture) {
    GAITCAM_ASSERT(texture >= 0 && texture < int(place_.textures.size()));
    std::string name = fmt::format("tex{}", texture);
    if (!written_textures_.insert(texture).second) return name;
    // mjrContext holds 100 textures, the sky among them, and says nothing about more.
    if (written_textures_.size() > 99) {
      throw BadInput(place_.file.string() + ": more than 99 textures; MuJoCo cannot draw so many");
    }
    const cv::Mat& picture = place_.textures[texture].bgr;
    bundle_.pictures.emplace_back(name, picture);
    assets_ += fmt::format(
        "<texture name='{0}' type='2d' builtin='flat' width='{1}' height='{2}'/>\n"
        "<material name='{0}' texture='{0}' specular='0' shininess='0' reflectance='0'/>\n",
        name, picture.cols, picture.rows);
    return name;
  }

  /// The floor collides as a plane without end; what is seen of it is its textured extent.
  void WriteFloor() {
    const Eigen::Vector3d sky = place_.background_rgb;
    assets_ += fmt::format(
        "<texture type='skybox' builtin='flat' rgb1='{0}' rgb2='{0}' width='32' height='192'/>\n"
        "<material name='matte' specular='0.1' shininess='0.2' reflectance='0'/>\n",
        Text(sky));
    const Eigen::Vector2d center = 0.5 * (place_.floor_min + place_.floor_max),
                          size = place_.floor_max - place_.floor_min;
    const bool textured = place_.floor_texture >= 0;
    bodies_ += fmt::format(
        "<geom name='floor' type='plane' pos='{} 0' size='{} 1' material='matte' rgba='.6 .6 .6 1' "
        "friction='{} 0.005 0.0001' priority='1' group='{}' {}/>\n",
        Text(center), Text(Eigen::Vector2d(0.5 * size)), place_.floor_friction, textured ? 3 : 0, kPlaceCollides);
    if (!textured) return;
    TexturedMesh mesh;  // a slab under z = 0, because MuJoCo wants meshes to have a volume
    const double depth = 0.01;
    mesh.AddFace({place_.floor_min.x(), place_.floor_min.y(), 0}, size.x() * Eigen::Vector3d::UnitX(),
                 size.y() * Eigen::Vector3d::UnitY(), place_.floor_texture_size_m);
    mesh.AddFace({place_.floor_min.x(), place_.floor_max.y(), -depth}, size.x() * Eigen::Vector3d::UnitX(),
                 -size.y() * Eigen::Vector3d::UnitY(), size);
    assets_ += mesh.ToXml("floor");
    scenery_ += fmt::format("<geom name='floor_picture' type='mesh' mesh='floor' material='{}' group='0' {}/>\n",
                            TextureMaterial(place_.floor_texture), kNoCollision);
  }

  /// MuJoCo pairs every shape of the world itself with every shape of the robot, but sorts bodies by their extent
  /// before it pairs theirs, at a cost that grows with the square of their number. So boxes that collide become a few
  /// bodies of neighbours, and all that is only seen is in the body `scenery`.
  void WriteBox(int index) {
    const PlaceBox& box = place_.boxes[index];
    const bool textured = box.texture >= 0;
    if (!textured || box.collides) {
      const std::string name = fmt::format("box{}", index);
      const std::string geom = fmt::format(
          "<geom name='{}' type='box' {} size='{}' material='matte' rgba='{} 1' friction='{} 0.005 0.0001' "
          "priority='1' group='{}' {}/>",
          name, PoseText(box.X_WB), Text(Eigen::Vector3d(0.5 * box.size)), Text(box.rgb), place_.floor_friction,
          textured ? 3 : 0, box.collides ? kPlaceCollides : kNoCollision);
      (box.collides ? neighbours_[Neighbourhood(box, index)] : scenery_) += geom + "\n";
    }
    if (!textured) return;
    TexturedMesh mesh;
    mesh.AddBox(box.size, box.texture_size_m);
    const std::string name = fmt::format("box{}_picture", index);
    assets_ += mesh.ToXml(name);
    scenery_ += fmt::format("<geom name='{0}' type='mesh' mesh='{0}' {1} material='{2}' group='0' {3}/>\n", name,
                            PoseText(box.X_WB), TextureMaterial(box.texture), kNoCollision);
  }

  /// Boxes whose centres are in the same square of 2 m; a large box is alone, or else it would stretch its group's
  /// extent.
  static std::array<int, 3> Neighbourhood(const PlaceBox& box, int index) {
    const double side_m = 2;
    const Eigen::Vector3d extent = box.X_WB.R().cwiseAbs() * box.size;
    if (extent.head<2>().maxCoeff() > side_m) return {0, 0, index + 1};
    const Eigen::Vector3d& p = box.X_WB.translation;
    return {int(std::floor(p.x() / side_m)), int(std::floor(p.y() / side_m)), 0};
  }

  /// Bodies that are put where they belong from outside, without mass or contact: the robot moves as if nobody were
  /// there. They come after the robot's, whose numbers they leave alone.
  void WritePerson(int index) {
    std::array<std::string, kPersonParts> geoms;
    const std::vector<PersonSurface> surfaces = PersonSurfaces(place_.people[index], place_.cloth_size_m);
    for (size_t i = 0; i < surfaces.size(); ++i) {
      const PersonSurface& surface = surfaces[i];
      const std::string mesh = fmt::format("person{}_{}", index, i);
      assets_ += SurfaceMesh(mesh, surface);
      geoms[size_t(surface.part)] +=
          fmt::format("<geom type='mesh' mesh='{}' material='{}' rgba='{} 1' group='0' {}/>\n", mesh,
                      surface.cloth ? TextureMaterial(place_.cloth_texture) : "matte",
                      Text(Eigen::Vector3d(surface.cloth ? ClothColor(surface.rgb) : surface.rgb)), kNoCollision);
    }
    for (int part = 0; part < kPersonParts; ++part) {
      bodies_ += fmt::format(
          "<body name='person{}.{}' mocap='true'>\n<inertial pos='0 0 0' mass='0' diaginertia='0 0 0'/>\n{}</body>\n",
          index, PersonPartName(PersonPart(part)), geoms[part]);
    }
  }

  static std::string SurfaceMesh(const std::string& name, const PersonSurface& surface) {
    std::string vertex, normal, texcoord, face;
    for (size_t i = 0; i < surface.vertices.size(); ++i) {
      vertex += Text(surface.vertices[i]) + " ";
      normal += Text(surface.normals[i]) + " ";
      texcoord += Text(surface.texcoords[i]) + " ";
    }
    for (const std::array<int, 3>& f : surface.faces) face += fmt::format("{} {} {} ", f[0], f[1], f[2]);
    return fmt::format("<mesh name='{}' vertex='{}' normal='{}' texcoord='{}' face='{}'/>\n", name, vertex, normal,
                       texcoord, face);
  }

  /// The cloth's picture is a light grey that the colour is multiplied with.
  Eigen::Vector3d ClothColor(const Eigen::Vector3d& rgb) const {
    const cv::Scalar mean = cv::mean(place_.textures[place_.cloth_texture].bgr) / 255;
    return (rgb.array() / Eigen::Array3d(mean[2], mean[1], mean[0]).max(0.1)).min(1.0);
  }

  void WriteLight(const PlaceLight& light) {
    bodies_ += fmt::format(
        "<light pos='{}' dir='{}' directional='{}' castshadow='{}' diffuse='{} {} {}' "
        "specular='.1 .1 .1' ambient='0 0 0' cutoff='85' exponent='1'/>\n",
        Text(light.position), Text(light.direction), light.directional, light.casts_shadow,
        light.brightness * light.rgb.x(), light.brightness * light.rgb.y(), light.brightness * light.rgb.z());
  }

  void WriteBody(int link_index) {
    const RobotLink& link = robot_.links[link_index];
    Pose X_PB(Eigen::Quaterniond::Identity(), {0, 0, robot_.base_height_m});
    if (link_index > 0) X_PB = robot_.joints[link_index - 1].X_PJ;
    bodies_ += fmt::format("<body name='{}' {}>\n", Escaped(link.name), PoseText(X_PB));
    if (link_index == 0) {
      WriteRootJoints();
    } else {
      WriteJoint(link_index - 1);
    }
    WriteInertia(link);
    const bool shows_collisions = link.visuals.empty();
    for (const RobotShape& shape : link.visuals) WriteShape(shape, 1, kNoCollision);
    for (const RobotShape& shape : link.collisions) WriteShape(shape, shows_collisions ? 1 : 3, kRobotCollides);
    WriteMounts(link_index);
    for (const RobotJoint& joint : robot_.joints) {
      if (joint.parent_link == link_index) WriteBody(joint.child_link);
    }
    bodies_ += "</body>\n";
  }

  void WriteRootJoints() {
    if (robot_.kind == Robot::Kind::kHumanoid) {
      bodies_ += "<freejoint name='root'/>\n";
    } else {
      bodies_ +=
          "<joint name='drive_x' type='slide' axis='1 0 0'/><joint name='drive_y' type='slide' axis='0 1 0'/>"
          "<joint name='drive_yaw' type='hinge' axis='0 0 1'/><joint name='drive_pitch' type='hinge' axis='0 1 0'/>"
          "<joint name='drive_roll' type='hinge' axis='1 0 0'/>\n";
    }
  }

  void WriteJoint(int index) {
    const RobotJoint& joint = robot_.joints[index];
    if (joint.kind == RobotJoint::Kind::kFixed) return;
    const ServoOptions& servo = robot_.servos[index];
    const bool slides = joint.kind == RobotJoint::Kind::kPrismatic;
    const std::string range =
        joint.kind == RobotJoint::Kind::kContinuous ? "" : fmt::format("range='{} {}' ", joint.lower, joint.upper);
    bodies_ += fmt::format("<joint name='{}' type='{}' axis='{}' {}armature='{}' damping='{}' frictionloss='{}'/>\n",
                           Escaped(joint.name), slides ? "slide" : "hinge", Text(joint.axis), range, servo.armature,
                           servo.damping, servo.friction);
  }

  void WriteInertia(const RobotLink& link) {
    const Eigen::Matrix3d& i = link.inertia;
    if (link.mass_kg > 0) {
      bodies_ += fmt::format("<inertial pos='{}' mass='{}' fullinertia='{} {} {} {} {} {}'/>\n", Text(link.com),
                             link.mass_kg, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
    } else {
      bodies_ += "<inertial pos='0 0 0' mass='0' diaginertia='0 0 0'/>\n";  // or MuJoCo weighs the shapes
    }
  }

  void WriteShape(const RobotShape& shape, int group, const char* collides) {
    std::string geometry;
    switch (shape.kind) {
      case RobotShape::Kind::kBox:
        geometry = fmt::format("type='box' size='{}'", Text(Eigen::Vector3d(0.5 * shape.size)));
        break;
      case RobotShape::Kind::kCylinder:
        geometry = fmt::format("type='cylinder' size='{} {}'", shape.size[0], 0.5 * shape.size[1]);
        break;
      case RobotShape::Kind::kSphere: geometry = fmt::format("type='sphere' size='{}'", shape.size[0]); break;
      case RobotShape::Kind::kMesh: geometry = "type='mesh' mesh='" + MeshAsset(shape) + "'"; break;
    }
    bodies_ += fmt::format("<geom {} {} material='matte' rgba='{}' group='{}' {}/>\n", geometry, PoseText(shape.X_LS),
                           Text(shape.rgba), group, collides);
  }

  std::string MeshAsset(const RobotShape& shape) {
    const std::string key = shape.mesh.string() + " " + Text(shape.size);
    const auto [found, is_new] = mesh_names_.emplace(key, fmt::format("mesh{}", mesh_names_.size()));
    if (!is_new) return found->second;
    std::ifstream stream(shape.mesh, std::ios::binary);
    if (!stream) throw BadInput(shape.mesh.string() + ": cannot read this mesh file");
    std::string extension = shape.mesh.extension().string();
    for (char& c : extension) c = char(std::tolower(c));
    const std::string file = found->second + extension;
    AddFile(file, {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()});
    assets_ += fmt::format("<mesh name='{}' file='{}' scale='{}'/>\n", found->second, file, Text(shape.size));
    return found->second;
  }

  /// MuJoCo's cameras look along their -z with y up: the optical frame turned by pi about x.
  void WriteMounts(int link_index) {
    if (robot_.imu.link == link_index)
      bodies_ += "<site name='imu' " + PoseText(robot_.imu.X_LS) + " size='.002' group='3'/>\n";
    if (robot_.camera.link != link_index) return;
    const Pose X_CV(Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero());
    for (const WorldCamera& camera : cameras_) {
      bodies_ += fmt::format("<camera name='{}' {} fovy='45'/>\n", Escaped(camera.name),
                             PoseText(robot_.camera.X_LS * camera.X_MC * X_CV));
    }
  }

  void WriteServo(const std::string& name, const std::string& joint, double kp, double kv, const std::string& limit) {
    actuators_ += fmt::format("<general name='{}' joint='{}' biastype='affine' gainprm='{}' biasprm='0 {} {}' {}/>\n",
                              Escaped(name), Escaped(joint), kp, -kp, -kv, limit);
  }

  void WriteActuators() {
    for (size_t i = 0; i < robot_.joints.size(); ++i) {
      if (robot_.joints[i].kind == RobotJoint::Kind::kFixed) continue;
      const ServoOptions& servo = robot_.servos[i];
      WriteServo("servo_" + robot_.joints[i].name, robot_.joints[i].name, servo.kp, servo.kv,
                 fmt::format("forcerange='{} {}'", -servo.torque_limit, servo.torque_limit));
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
    WriteServo(joint, joint, inertia * omega * omega, 2 * damping_ratio * inertia * omega, "");
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
  const Place& place_;
  const PhysicsOptions& physics_;
  const std::vector<WorldCamera>& cameras_;
  MjcfBundle bundle_;
  std::string assets_, bodies_, scenery_, actuators_;
  std::map<std::array<int, 3>, std::string> neighbours_;
  std::set<int> written_textures_;
  std::map<std::string, std::string> mesh_names_;
};

}  // namespace

MjcfBundle BuildMjcf(const Robot& robot, const Place& place, const PhysicsOptions& physics,
                     const std::vector<WorldCamera>& cameras) {
  return MjcfWriter(robot, place, physics, cameras).Write();
}

}  // namespace gaitcam
