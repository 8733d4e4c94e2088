/// A scenario: who walks how, where, filmed by what, tracked by which system, and scored how. One YAML file.

#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/slam/system.h"
#include "models/gait.h"
#include "models/place.h"
#include "models/robot.h"
#include "models/yaml_fields.h"
#include "results/score.h"
#include "sim/camera_rig.h"
#include "sim/omni_drive.h"
#include "sim/path.h"
#include "sim/sensors.h"
#include "sim/world.h"

namespace gaitcam {

/// `gait:` a preset of the robot, and single numbers that differ from it.
struct GaitChoice {
  using DescribedTag = void;
  std::string preset = "normal";
  GaitOptions options;  ///< The preset with the scenario's changes, once resolved.
};

template <class Visitor>
void VisitFields(Visitor& visit, GaitChoice& o) {
  visit("preset", o.preset, AnyText(), "a preset of the robot: slow, normal, brisk, or one of its own");
  VisitFields(visit, o.options);
}

/// `system:` a name, or a map of a name and settings: `{name: mobif_vo, feature: akaze, ratio: 0.8}`.
struct SystemChoice {
  std::string name = "sift_vo";
  SystemSettings settings;
};

void ReadYaml(const YamlNode& node, SettingValue& value);
void WriteYaml(YAML::Emitter& out, const SettingValue& value);
/// Settings of a map but for its key `name`; groups (maps) are named by a dot: `matching.ratio`.
void ReadYaml(const YamlNode& node, SystemSettings& settings, const std::string& prefix);
void ReadYaml(const YamlNode& node, SystemChoice& value);
void WriteYaml(YAML::Emitter& out, const SystemChoice& value);

/// `video:` the short film that goes with a report.
struct ReportFilmOptions {
  using DescribedTag = void;
  bool enabled = true;
  double rate_hz = 15;  ///< Frames of the film per second of the walk.
  int height_px = 270;  ///< Of both halves.
};

template <class Visitor>
void VisitFields(Visitor& visit, ReportFilmOptions& o) {
  visit("enabled", o.enabled, Nested(), "write walk.mp4");
  visit("rate_hz", o.rate_hz, Between(1, 60), "film frames per second of the walk");
  visit("height_px", o.height_px, Between(120, 1080), "height of the film");
}

struct Scenario {
  using DescribedTag = void;

  std::string name;  ///< Defaults to the file's name.
  std::string description;
  std::string robot = "khr1hv";  ///< Shipped name, or path of a robot YAML.
  std::string place = "lab";     ///< Shipped name, or path of a place YAML.
  uint64_t seed = 1;
  double duration_s = 20;  ///< Ends here, or when the path ends, whichever is first; 0: when the path ends.
  std::optional<Eigen::Vector3d> start;  ///< x m, y m, yaw deg; the place's own start if absent.
  GaitChoice gait;
  PathOptions path;
  PhysicsOptions physics;
  OmniDriveOptions drive;  ///< Wheeled base only.
  CameraOptions camera;
  SensorOptions sensors;
  SystemChoice system;
  ScoreOptions score;
  ReportFilmOptions video;
};

template <class Visitor>
void VisitFields(Visitor& visit, Scenario& o) {
  visit("name", o.name, AnyText(), "defaults to the file's name");
  visit("description", o.description, AnyText(), "one line for people");
  visit("robot", o.robot, AnyText(), "shipped robot, or path of a robot YAML");
  visit("place", o.place, AnyText(), "shipped place, or path of a place YAML");
  visit("seed", o.seed, AtLeast(0), "all randomness of the run derives from it");
  visit("duration_s", o.duration_s, Between(0, 36000), "longest time; 0 is until the path ends");
  visit("start", o.start, Nested(), "x m, y m, yaw deg; the place's start if absent");
  visit("gait", o.gait, Nested(), "how to walk");
  visit("path", o.path, Nested(), "where to walk");
  visit("physics", o.physics, Nested(), "MuJoCo's step, and what is off about masses and friction");
  visit("drive", o.drive, Nested(), "wheeled base: speed and vibration");
  visit("camera", o.camera, Nested(), "the head camera");
  visit("sensors", o.sensors, Nested(), "IMU, encoders");
  visit("system", o.system, Nested(), "SLAM system: a name, or {name: ..., setting: ...}");
  visit("score", o.score, Nested(), "association and alignment");
  visit("video", o.video, Nested(), "the film of the report");
}

/// A scenario and all that it names, read and checked: nothing of the user's input is left to fail during the run.
struct ResolvedScenario {
  Scenario scenario;
  Robot robot;
  Place place;
  std::filesystem::path file;

  /// The whole scenario as YAML, every default written out; reading it again gives the same run.
  std::string ToYaml() const;
};

/// Reads a scenario file, applies `--set` assignments in order, and resolves robot, place and gait.
/// @throws BadInput or BadOption with one line: file, line, column, key, value and what would be right.
ResolvedScenario ReadScenario(const std::filesystem::path& file, const std::vector<std::string>& assignments);

}  // namespace gaitcam
