#include "algorithms/io/calibration_file.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

constexpr double kNotUnit = 1e-3;  // calibrations by others have six digits or so

/// A map in a YAML file; what it is asked for must be there.
class YamlMap {
 public:
  explicit YamlMap(const std::filesystem::path& file) : file_(file.string()) {
    std::string text = FileContent(file);
    if (text.rfind("%YAML", 0) == 0) text[0] = '#';  // OpenCV's "%YAML:1.0" is not YAML; as a comment it does no harm
    try {
      node_ = YAML::Load(text);
    } catch (const YAML::ParserException& e) {
      throw BadInput(file_ + ":" + std::to_string(e.mark.line + 1) + ": not valid YAML: " + e.msg);
    }
    if (!node_.IsMap()) Fail(node_, "expected a map of keys and values");
  }

  bool Has(const std::string& key) const { return node_[key].IsDefined(); }

  YamlMap Map(const std::string& key) const {
    const YAML::Node child = Required(key);
    if (!child.IsMap()) Fail(child, key + ": expected a map of keys and values");
    return {file_, child};
  }

  /// A list of maps.
  std::vector<YamlMap> Maps(const std::string& key) const {
    const YAML::Node list = Required(key);
    if (!list.IsSequence() || list.size() == 0) Fail(list, key + ": expected a list of maps of keys and values");
    std::vector<YamlMap> maps;
    for (const YAML::Node& element : list) {
      if (!element.IsMap()) Fail(element, key + ": expected a list of maps of keys and values");
      maps.push_back({file_, element});
    }
    return maps;
  }

  double Number(const std::string& key) const { return Scalar<double>(Required(key), key, "a number"); }
  int Integer(const std::string& key) const { return Scalar<int>(Required(key), key, "a whole number"); }
  bool Flag(const std::string& key) const { return Scalar<bool>(Required(key), key, "true or false"); }
  std::string Text(const std::string& key) const { return Scalar<std::string>(Required(key), key, "a text"); }

  /// @param most if larger than `fewest`, lists of up to so many numbers are accepted.
  std::vector<double> Numbers(const std::string& key, size_t fewest, size_t most = 0) const {
    const YAML::Node list = Required(key);
    most = std::max(fewest, most);
    if (!list.IsSequence() || list.size() < fewest || list.size() > most) {
      Fail(list, key + ": expected a list of " + std::to_string(fewest) +
                     (most > fewest ? " to " + std::to_string(most) : "") + " numbers");
    }
    std::vector<double> numbers;
    for (const YAML::Node& element : list) numbers.push_back(Scalar<double>(element, key, "a list of numbers"));
    return numbers;
  }

  void RejectUnknown(const std::vector<std::string>& known) const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      Fail(entry.first, key + ": unknown key; " + DidYouMean(key, known, "known here: " + JoinWords(known)));
    }
  }

  [[noreturn]] void Fail(const std::string& key, const std::string& message) const {
    Fail(node_[key], key + ": " + message);
  }

 private:
  YamlMap(std::string file, const YAML::Node& node) : file_(std::move(file)), node_(node) {}

  YAML::Node Required(const std::string& key) const {
    const YAML::Node child = node_[key];
    if (!child.IsDefined()) Fail(node_, "the key " + key + " is missing");
    return child;
  }

  template <class T>
  T Scalar(const YAML::Node& node, const std::string& key, const char* expected) const {
    T value{};
    bool good = node.IsScalar();
    if (good) {
      try {
        value = node.as<T>();
      } catch (const YAML::Exception&) {
        good = false;
      }
    }
    if constexpr (std::is_same_v<T, double>) good = good && std::isfinite(value);
    if (!good) Fail(node, key + ": expected " + expected);
    return value;
  }

  [[noreturn]] void Fail(const YAML::Node& node, const std::string& message) const {
    const int line = node.IsDefined() && !node.Mark().is_null() ? node.Mark().line : 0;
    throw BadInput(file_ + ":" + std::to_string(line + 1) + ": " + message);
  }

  std::string file_;
  YAML::Node node_;
};

const std::vector<std::string> kCameraKeys = {"width_px", "height_px", "fx", "fy", "cx", "cy",
                                              "k1",       "k2",        "p1", "p2", "k3"};

std::string CameraText(const std::string& key, const CameraModel& c) {
  std::string text =
      key + ":\n  width_px: " + std::to_string(c.width_px) + "\n  height_px: " + std::to_string(c.height_px) + "\n";
  const std::vector<double> numbers = {c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3};
  for (size_t i = 0; i < numbers.size(); ++i) text += "  " + kCameraKeys[i + 2] + ": " + ExactText(numbers[i]) + "\n";
  return text;
}

CameraModel ReadCamera(const YamlMap& map) {
  map.RejectUnknown(kCameraKeys);
  CameraModel c;
  c.width_px = map.Integer("width_px");
  c.height_px = map.Integer("height_px");
  const std::vector<double*> members = {&c.fx, &c.fy, &c.cx, &c.cy, &c.k1, &c.k2, &c.p1, &c.p2, &c.k3};
  for (size_t i = 0; i < members.size(); ++i) *members[i] = map.Number(kCameraKeys[i + 2]);
  for (const char* key : {"width_px", "height_px", "fx", "fy"}) {
    if (!(map.Number(key) > 0)) map.Fail(key, "expected a number greater than 0");
  }
  return c;
}

std::string PoseText(const std::string& indent, const std::string& key, const Pose& X) {
  const Eigen::Vector3d& t = X.translation;
  const Eigen::Quaterniond& q = X.rotation;
  return indent + key + ":\n" + indent + "  translation_m: " + ExactList({t.x(), t.y(), t.z()}) + "\n" + indent +
         "  rotation_xyzw: " + ExactList({q.x(), q.y(), q.z(), q.w()}) + "\n";
}

Pose ReadPose(const YamlMap& map) {
  map.RejectUnknown({"translation_m", "rotation_xyzw"});
  const std::vector<double> t = map.Numbers("translation_m", 3), q = map.Numbers("rotation_xyzw", 4);
  Pose X;
  X.translation = {t[0], t[1], t[2]};
  X.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);  // as it stands: normalising again would move the last bit
  const double norm = X.rotation.norm();
  if (std::abs(norm - 1) > kNotUnit) map.Fail("rotation_xyzw", "has length " + ExactText(norm) + "; expected 1");
  constexpr double kRounding = 1e-14;
  if (std::abs(norm - 1) > kRounding) X.rotation.normalize();
  return X;
}

const std::vector<std::string> kImuNumbers = {"rate_hz", "gyro_noise_density", "gyro_random_walk",
                                              "accel_noise_density", "accel_random_walk"};

std::vector<double*> ImuMembers(ImuCalibration& imu) {
  return {&imu.rate_hz, &imu.gyro_noise_density, &imu.gyro_random_walk, &imu.accel_noise_density,
          &imu.accel_random_walk};
}

ImuCalibration ReadImu(const YamlMap& map) {
  std::vector<std::string> known = kImuNumbers;
  known.push_back("X_CI");
  map.RejectUnknown(known);
  ImuCalibration imu;
  const std::vector<double*> members = ImuMembers(imu);
  for (size_t i = 0; i < members.size(); ++i) {
    *members[i] = map.Number(kImuNumbers[i]);
    if (*members[i] < 0) map.Fail(kImuNumbers[i], "expected a number of at least 0");
  }
  imu.X_CI = ReadPose(map.Map("X_CI"));
  return imu;
}

double SigmaOf(const YamlMap& map, const char* key) {
  const double sigma = map.Number(key);
  if (sigma < 0) map.Fail(key, "expected a standard deviation of at least 0");
  return sigma;
}

StandingCamera ReadStanding(const YamlMap& map) {
  map.RejectUnknown({"height_m", "up_C", "height_sigma", "pitch_sigma"});
  StandingCamera standing;
  standing.height_m = map.Number("height_m");
  if (!(standing.height_m > 0)) map.Fail("height_m", "expected a height above 0");
  const std::vector<double> up = map.Numbers("up_C", 3);
  standing.up_C = {up[0], up[1], up[2]};
  if (std::abs(standing.up_C.norm() - 1) > kNotUnit) map.Fail("up_C", "expected a vector of length 1");
  for (const auto& [key, member] :
       {std::pair{"height_sigma", &standing.height_sigma}, {"pitch_sigma", &standing.pitch_sigma}}) {
    if (map.Has(key)) *member = SigmaOf(map, key);
  }
  return standing;
}

std::string MatrixText(const Pose& X) {
  const Eigen::Matrix4d M = X.Matrix();
  std::string text = "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int i = 0; i < 16; ++i) {
    text += ExactText(M(i / 4, i % 4)) + (i == 15 ? "]\n" : i % 4 == 3 ? ",\n         " : ", ");
  }
  return text;
}

/// A list of 16 numbers, row by row.
Pose ReadMatrix(const YamlMap& map, const std::string& key) {
  const std::vector<double> data = map.Numbers(key, 16);
  const Eigen::Matrix4d M = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data.data());
  const Eigen::Matrix3d R = M.topLeftCorner<3, 3>();
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kNotUnit || R.determinant() < 0) {
    map.Fail(key, R.determinant() < 0
                      ? "the upper left 3 x 3 numbers are not a rotation matrix: they mirror (determinant below 0)"
                      : "the upper left 3 x 3 numbers are not a rotation matrix");
  }
  return {R, M.topRightCorner<3, 1>()};
}

/// Body to left camera: the body is the IMU where there is one.
Pose X_BC(const Calibration& calibration) {
  return calibration.imu.rate_hz > 0 ? calibration.imu.X_CI.Inverse() : Pose();
}

/// [k1, k2, p1, p2], and k3 where it is not zero.
std::vector<double> DistortionOf(const CameraModel& c) {
  std::vector<double> distortion = {c.k1, c.k2, c.p1, c.p2};
  if (c.k3 != 0) distortion.push_back(c.k3);
  return distortion;
}

struct PlacedCamera {
  CameraModel camera;
  Pose X_BC;
  double rate_hz = 0;
};

bool IsSizeOfImage(const std::vector<double>& size) {
  constexpr double kLargest_px = 100000;
  return size[0] >= 1 && size[1] >= 1 && size[0] <= kLargest_px && size[1] <= kLargest_px;
}

/// @param size [width, height] px @param k [fx, fy, cx, cy] @param d as DistortionOf gives them
CameraModel Camera(const std::vector<double>& size, const std::vector<double>& k, const std::vector<double>& d) {
  CameraModel c;
  c.width_px = int(size[0]);
  c.height_px = int(size[1]);
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  c.k1 = d[0], c.k2 = d[1], c.p1 = d[2], c.p2 = d[3], c.k3 = d.size() > 4 ? d[4] : 0.0;
  return c;
}

PlacedCamera ReadEurocCamera(const std::filesystem::path& file) {
  const YamlMap map(file);
  PlacedCamera result;
  if (const std::string model = map.Text("camera_model"); model != "pinhole") {
    map.Fail("camera_model", model + " is not supported; expected pinhole");
  }
  const std::string distortion = map.Text("distortion_model");
  if (distortion != "radial-tangential" && distortion != "radtan") {
    map.Fail("distortion_model", distortion + " is not supported; expected radial-tangential");
  }
  const std::vector<double> size = map.Numbers("resolution", 2), k = map.Numbers("intrinsics", 4),
                            d = map.Numbers("distortion_coefficients", 4, 5);
  if (!IsSizeOfImage(size)) map.Fail("resolution", "expected [width, height] from 1 to 100000 pixels");
  if (!(k[0] > 0 && k[1] > 0)) map.Fail("intrinsics", "expected [fu, fv, cu, cv] with positive focal lengths");
  result.camera = Camera(size, k, d);
  result.X_BC = ReadMatrix(map.Map("T_BS"), "data");
  result.rate_hz = map.Number("rate_hz");
  return result;
}

PlacedCamera ReadVslamlabCamera(const YamlMap& map) {
  PlacedCamera result;
  if (const std::string model = map.Text("cam_model"); model != "pinhole") {
    map.Fail("cam_model", model + " is not supported; expected pinhole");
  }
  std::vector<double> distortion(4, 0.0);
  if (map.Has("distortion_type")) {
    const std::string type = map.Text("distortion_type");
    if (type != "radtan4" && type != "radtan5") {
      map.Fail("distortion_type", type + " is not supported; expected radtan4 or radtan5");
    }
    distortion = map.Numbers("distortion_coefficients", type == "radtan4" ? 4 : 5);
  }
  const std::vector<double> size = map.Numbers("image_dimension", 2), f = map.Numbers("focal_length", 2),
                            c = map.Numbers("principal_point", 2);
  if (!IsSizeOfImage(size)) map.Fail("image_dimension", "expected [width, height] from 1 to 100000 pixels");
  if (!(f[0] > 0 && f[1] > 0)) map.Fail("focal_length", "expected two numbers greater than 0");
  result.camera = Camera(size, {f[0], f[1], c[0], c[1]}, distortion);
  result.X_BC = ReadMatrix(map, "T_BS");
  result.rate_hz = map.Number("fps");
  return result;
}

/// Row by row.
std::string Flat(const Pose& X) {
  const Eigen::Matrix4d M = X.Matrix();
  std::vector<double> numbers;
  for (int i = 0; i < 16; ++i) numbers.push_back(M(i / 4, i % 4));
  return ExactList(numbers);
}

std::string VslamlabCamera(const Calibration& calibration, bool right, const std::string& type) {
  const CameraModel& c = right ? *calibration.right : calibration.camera;
  const Pose X_BS = right ? X_BC(calibration) * calibration.X_LR : X_BC(calibration);
  const std::string depth = "    depth_name: depth_0\n    depth_factor: " + ExactText(kDepthUnitsPerMetre) + "\n";
  return std::string("  - cam_name: ") + (right ? "rgb_1" : "rgb_0") + "\n    cam_type: " + type + "\n" +
         (calibration.has_depth && !right ? depth : "") +
         "    cam_model: pinhole\n    distortion_type: " + (c.k3 != 0 ? "radtan5" : "radtan4") +
         "\n    focal_length: " + ExactList({c.fx, c.fy}) + "\n    principal_point: " + ExactList({c.cx, c.cy}) +
         "\n    distortion_coefficients: " + ExactList(DistortionOf(c)) +
         "\n    image_dimension: " + ExactList({double(c.width_px), double(c.height_px)}) +
         "\n    fps: " + ExactText(calibration.frame_rate_hz) + "\n    T_BS: " + Flat(X_BS) + "\n";
}

LensUncertainty ReadLens(const YamlMap& map) {
  map.RejectUnknown({"focal", "centre_px", "right_focal"});
  LensUncertainty lens;
  for (const auto& [key, member] :
       {std::pair{"focal", &lens.focal}, {"centre_px", &lens.centre_px}, {"right_focal", &lens.right_focal}}) {
    if (map.Has(key)) *member = SigmaOf(map, key);
  }
  return lens;
}

DepthCalibration ReadDepth(const YamlMap& map) {
  map.RejectUnknown({"sigma_m", "sigma_per_m"});
  return {SigmaOf(map, "sigma_m"), SigmaOf(map, "sigma_per_m")};
}

const std::vector<std::string> kOdometrySigmas = {"position_per_sqrt_m", "heading_per_sqrt_m", "heading_per_sqrt_rad",
                                                  "rocking_m", "rocking_rad"};
constexpr size_t kNeededSigmas = 3;  // older files have no others

std::vector<double*> OdometrySigmas(OdometryCalibration& odometry) {
  return {&odometry.position_per_sqrt_m, &odometry.heading_per_sqrt_m, &odometry.heading_per_sqrt_rad,
          &odometry.rocking_m, &odometry.rocking_rad};
}

OdometryCalibration ReadOdometry(const YamlMap& map) {
  std::vector<std::string> known = kOdometrySigmas;
  known.insert(known.end(), {"rate_hz", "X_BC"});
  map.RejectUnknown(known);
  OdometryCalibration odometry;
  odometry.rate_hz = map.Number("rate_hz");
  if (!(odometry.rate_hz > 0)) map.Fail("rate_hz", "expected a rate above 0 Hz");
  odometry.X_BC = ReadPose(map.Map("X_BC"));
  const std::vector<double*> members = OdometrySigmas(odometry);
  for (size_t i = 0; i < members.size(); ++i) {
    const char* key = kOdometrySigmas[i].c_str();
    if (i < kNeededSigmas || map.Has(key)) *members[i] = SigmaOf(map, key);
  }
  return odometry;
}

std::string OdometryText(OdometryCalibration odometry) {
  std::string text =
      "odometry:  # of the body B, on the floor below its trunk; standard deviations after 1 m, or 1 rad; of\n"
      "           # its height and tilt at any time (rocking); m, rad\n";
  text += "  rate_hz: " + ExactText(odometry.rate_hz) + "\n" + PoseText("  ", "X_BC", odometry.X_BC);
  const std::vector<double*> members = OdometrySigmas(odometry);
  for (size_t i = 0; i < members.size(); ++i) text += "  " + kOdometrySigmas[i] + ": " + ExactText(*members[i]) + "\n";
  return text;
}

}  // namespace

std::string CalibrationText(const Calibration& calibration) {
  std::string text =
      "# Pinhole cameras with radial-tangential distortion; pixels from the centre of the first one.\n"
      "# X_AB maps points of B into A. C is the left camera (x right, y down, z forward), R the right one, I the IMU.\n"
      "# IMU noise: continuous-time densities (rad/s and m/s^2 per sqrt(Hz)) and random walks; rate 0 means no IMU.\n";
  text += CameraText("camera", calibration.camera);
  if (calibration.right) {
    text += CameraText("right", *calibration.right) + PoseText("", "X_LR", calibration.X_LR);
  }
  text += std::string("has_depth: ") + (calibration.has_depth ? "true" : "false") + "\n";
  text += "frame_rate_hz: " + ExactText(calibration.frame_rate_hz) + "\n";
  text += "readout_ms: " + ExactText(calibration.readout_ms) + "  # first row to last; 0: global shutter\nimu:\n";
  ImuCalibration imu = calibration.imu;
  const std::vector<double*> members = ImuMembers(imu);
  for (size_t i = 0; i < members.size(); ++i) text += "  " + kImuNumbers[i] + ": " + ExactText(*members[i]) + "\n";
  text += PoseText("  ", "X_CI", imu.X_CI);
  if (const LensUncertainty& lens = calibration.lens; !lens.IsExact()) {
    text += "lens:  # one standard deviation: a part of the focal length; px of the principal point's coordinates\n";
    text += "  focal: " + ExactText(lens.focal) + "\n  centre_px: " + ExactText(lens.centre_px) +
            "\n  right_focal: " + ExactText(lens.right_focal) + "\n";
  }
  if (const DepthCalibration& depth = calibration.depth; depth.Sigma(1) > 0) {
    text += "depth:  # standard deviations: at any distance, m; of one that grows with its square, m at 1 m\n";
    text += "  sigma_m: " + ExactText(depth.sigma_m) + "\n  sigma_per_m: " + ExactText(depth.sigma_per_m) + "\n";
  }
  if (calibration.odometry.rate_hz > 0) text += OdometryText(calibration.odometry);
  if (!calibration.standing) return text;
  const StandingCamera& standing = *calibration.standing;
  const Eigen::Vector3d& up = standing.up_C;
  text += "standing:  # over the soles, ready to walk\n  height_m: " + ExactText(standing.height_m) +
          "\n  up_C: " + ExactList({up.x(), up.y(), up.z()}) + "\n";
  if (standing.height_sigma == 0 && standing.pitch_sigma == 0) return text;
  return text + "  height_sigma: " + ExactText(standing.height_sigma) +
         "  # a part of the height\n  pitch_sigma: " + ExactText(standing.pitch_sigma) + "  # rad\n";
}

Calibration ReadCalibration(const std::filesystem::path& file) {
  const YamlMap map(file);
  map.RejectUnknown({"camera", "right", "X_LR", "has_depth", "frame_rate_hz", "readout_ms", "imu", "standing", "lens",
                     "depth", "odometry"});
  Calibration calibration;
  calibration.camera = ReadCamera(map.Map("camera"));
  if (map.Has("right")) {
    calibration.right = ReadCamera(map.Map("right"));
    calibration.X_LR = ReadPose(map.Map("X_LR"));
  }
  if (map.Has("has_depth")) calibration.has_depth = map.Flag("has_depth");
  if (map.Has("frame_rate_hz")) calibration.frame_rate_hz = map.Number("frame_rate_hz");
  if (map.Has("readout_ms")) {  // files of before know no rolling shutter
    calibration.readout_ms = map.Number("readout_ms");
    if (calibration.readout_ms < 0) map.Fail("readout_ms", "expected a time of at least 0 ms");
  }
  if (map.Has("lens")) calibration.lens = ReadLens(map.Map("lens"));
  if (map.Has("imu")) calibration.imu = ReadImu(map.Map("imu"));
  if (map.Has("depth")) calibration.depth = ReadDepth(map.Map("depth"));
  if (map.Has("odometry")) calibration.odometry = ReadOdometry(map.Map("odometry"));
  if (map.Has("standing")) calibration.standing = ReadStanding(map.Map("standing"));
  return calibration;
}

std::string EurocCameraText(const Calibration& calibration, bool right) {
  GAITCAM_ASSERT(!right || calibration.right);
  const CameraModel& c = right ? *calibration.right : calibration.camera;
  const Pose X_BS = right ? X_BC(calibration) * calibration.X_LR : X_BC(calibration);
  std::string text =
      "sensor_type: camera\ncomment: " + std::string(right ? "right" : "left") +
      " camera; images are stamped at mid-exposure\n\n# Maps points of the camera into the body, which is " +
      (calibration.imu.rate_hz > 0 ? "the IMU.\n" : "the left camera.\n") + MatrixText(X_BS) +
      "\nrate_hz: " + ExactText(calibration.frame_rate_hz) + "\nresolution: [" + std::to_string(c.width_px) + ", " +
      std::to_string(c.height_px) + "]\ncamera_model: pinhole\nintrinsics: " + ExactList({c.fx, c.fy, c.cx, c.cy}) +
      "  # fu, fv, cu, cv\ndistortion_model: radial-tangential\ndistortion_coefficients: " +
      ExactList(DistortionOf(c)) + (c.k3 != 0 ? "  # k1, k2, p1, p2, k3\n" : "  # k1, k2, p1, p2\n");
  return text;
}

std::string EurocImuText(const Calibration& calibration) {
  const ImuCalibration& imu = calibration.imu;
  return "sensor_type: imu\ncomment: simulated IMU; it is the body\n\n" + MatrixText(Pose()) +
         "\nrate_hz: " + ExactText(imu.rate_hz) + "\ngyroscope_noise_density: " + ExactText(imu.gyro_noise_density) +
         "  # rad/s/sqrt(Hz)" + "\ngyroscope_random_walk: " + ExactText(imu.gyro_random_walk) + "  # rad/s^2/sqrt(Hz)" +
         "\naccelerometer_noise_density: " + ExactText(imu.accel_noise_density) + "  # m/s^2/sqrt(Hz)" +
         "\naccelerometer_random_walk: " + ExactText(imu.accel_random_walk) + "  # m/s^3/sqrt(Hz)\n";
}

std::string EurocTruthText() {
  return "sensor_type: visual-inertial\ncomment: exact pose of the body at mid-exposure, from the simulator\n\n" +
         MatrixText(Pose());
}

Calibration ReadEurocCalibration(const std::filesystem::path& mav0) {
  Calibration calibration;
  const PlacedCamera left = ReadEurocCamera(mav0 / "cam0" / "sensor.yaml");
  calibration.camera = left.camera;
  calibration.frame_rate_hz = left.rate_hz;
  if (std::filesystem::exists(mav0 / "cam1" / "sensor.yaml")) {
    const PlacedCamera right = ReadEurocCamera(mav0 / "cam1" / "sensor.yaml");
    calibration.right = right.camera;
    calibration.X_LR = left.X_BC.Inverse() * right.X_BC;
  }
  if (std::filesystem::exists(mav0 / "imu0" / "sensor.yaml")) {
    const YamlMap map(mav0 / "imu0" / "sensor.yaml");
    ImuCalibration& imu = calibration.imu;
    imu.rate_hz = map.Number("rate_hz");
    imu.gyro_noise_density = map.Number("gyroscope_noise_density");
    imu.gyro_random_walk = map.Number("gyroscope_random_walk");
    imu.accel_noise_density = map.Number("accelerometer_noise_density");
    imu.accel_random_walk = map.Number("accelerometer_random_walk");
    imu.X_CI = left.X_BC.Inverse() * ReadMatrix(map.Map("T_BS"), "data");
  }
  return calibration;
}

std::string VslamlabCalibrationText(const Calibration& calibration, bool grey) {
  const std::string colour = grey ? "gray" : "rgb";
  std::string text = "%YAML 1.2\n---\n# T_BS maps points of the sensor into the body, which is " +
                     std::string(calibration.imu.rate_hz > 0 ? "the IMU" : "the left camera") +
                     ". Pixels from the centre of the first one.\ncameras:\n" +
                     VslamlabCamera(calibration, false, calibration.has_depth ? "rgb+depth" : colour);
  if (calibration.right) text += VslamlabCamera(calibration, true, colour);
  const ImuCalibration& imu = calibration.imu;
  if (imu.rate_hz <= 0) return text;
  return text + "imus:\n  - imu_name: imu_0\n    fps: " + ExactText(imu.rate_hz) +
         "\n    sigma_g_c: " + ExactText(imu.gyro_noise_density) + "  # gyroscope's noise density, rad/s/sqrt(Hz)" +
         "\n    sigma_a_c: " + ExactText(imu.accel_noise_density) +
         "  # accelerometer's noise density, m/s^2/sqrt(Hz)" + "\n    sigma_gw_c: " + ExactText(imu.gyro_random_walk) +
         "  # gyroscope's random walk, rad/s^2/sqrt(Hz)" + "\n    sigma_aw_c: " + ExactText(imu.accel_random_walk) +
         "  # accelerometer's random walk, m/s^3/sqrt(Hz)" +
         "\n    sigma_bg: 0.01  # prior of the gyroscope's bias, rad/s" +
         "\n    sigma_ba: 0.1  # prior of the accelerometer's bias, m/s^2" +
         "\n    a_max: 1000  # the readings never saturate" + "\n    g_max: 1000" +
         "\n    a0: [0, 0, 0]\n    g0: [0, 0, 0]\n    g: 9.81\n    s_a: [1, 1, 1]\n    T_BS: " + Flat(Pose()) + "\n";
}

Calibration ReadVslamlabCalibration(const std::filesystem::path& file) {
  const YamlMap map(file);
  const std::vector<YamlMap> cameras = map.Maps("cameras");
  Calibration calibration;
  const PlacedCamera left = ReadVslamlabCamera(cameras[0]);
  calibration.camera = left.camera;
  calibration.frame_rate_hz = left.rate_hz;
  calibration.has_depth = cameras[0].Has("depth_name");
  if (cameras.size() > 1) {
    const PlacedCamera right = ReadVslamlabCamera(cameras[1]);
    calibration.right = right.camera;
    calibration.X_LR = left.X_BC.Inverse() * right.X_BC;
  }
  if (!map.Has("imus")) return calibration;
  const YamlMap sensor = map.Maps("imus")[0];
  ImuCalibration& imu = calibration.imu;
  imu.rate_hz = sensor.Number("fps");
  imu.gyro_noise_density = sensor.Number("sigma_g_c");
  imu.accel_noise_density = sensor.Number("sigma_a_c");
  imu.gyro_random_walk = sensor.Number("sigma_gw_c");
  imu.accel_random_walk = sensor.Number("sigma_aw_c");
  imu.X_CI = left.X_BC.Inverse() * ReadMatrix(sensor, "T_BS");
  return calibration;
}

}  // namespace gaitcam
