/// A scenario: who walks how, where, filmed by what, tracked by which system, and scored how. One YAML file.

#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/option_reader.h"
#include "models/code/people/crowd.h"
#include "models/code/robots/gait.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "results/scoring/score.h"
#include "scenarios/code/files/calibration_error_options.h"
#include "scenarios/code/files/localisation_options.h"
#include "scenarios/code/files/variation.h"
#include "scenarios/code/systems/system_choice.h"
#include "sim/camera/camera_rig.h"
#include "sim/sensors/sensors.h"
#include "sim/walking/head_scan.h"
#include "sim/walking/kidnap.h"
#include "sim/walking/omni_drive.h"
#include "sim/walking/path.h"
#include "sim/world/world.h"

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

/// `handicap:` makes the system worse on purpose, to prove that a gate catches it. The defaults change nothing.
struct HandicapOptions {
  using DescribedTag = void;
  double pose_noise = 0;
  double pose_noise_deg = 0;
  int drop_every = 0;
  double focal_factor = 1;
  double late_ms = 0;
  double scale_factor = 1;
  double yaw_deg_per_m = 0;
  double jump = 0;
  int garbage_every = 0;
  int crash_at_frame = 0;
};

template <class Visitor>
void VisitFields(Visitor& visit, HandicapOptions& o) {
  visit("pose_noise", o.pose_noise, Between(0, 100),
        "standard deviation added to every position, per axis, in the estimate's own unit");
  visit("pose_noise_deg", o.pose_noise_deg, Between(0, 180), "standard deviation added to every orientation");
  visit("drop_every", o.drop_every, Between(0, 1000000), "every n-th frame never reaches the system; 0: all do");
  visit("focal_factor", o.focal_factor, Between(0.1, 10),
        "the system is told a focal length that is off by this factor");
  visit("late_ms", o.late_ms, Between(-10000, 10000), "poses are stamped so much later than they are");
  visit("scale_factor", o.scale_factor, Between(1e-6, 1e6), "all positions are multiplied by this");
  visit("yaw_deg_per_m", o.yaw_deg_per_m, Between(-360, 360),
        "the path bends by so much about the image's vertical per unit of the estimate's camera path");
  visit("jump", o.jump, Between(0, 1000),
        "from its 20th pose on the estimate is so far beside itself, in its own unit");
  visit("garbage_every", o.garbage_every, Between(0, 1000000),
        "for one seed in so many (those that it divides) poses are random; 0: for none");
  visit("crash_at_frame", o.crash_at_frame, Between(0, 1000000000), "the system stops working there; 0: it does not");
}

/// `video:` the short film that goes with a report.
struct ReportFilmOptions {
  using DescribedTag = void;
  bool enabled = true;
  double rate_hz = 15;
  int height_px = 270;
};

template <class Visitor>
void VisitFields(Visitor& visit, ReportFilmOptions& o) {
  visit("enabled", o.enabled, Nested(), "write walk.mp4, and of a drive by a map drive.mp4");
  visit("rate_hz", o.rate_hz, Between(1, 60), "film frames per second of the walk");
  visit("height_px", o.height_px, Between(120, 1080), "of both halves of the film");
}

struct Scenario {
  using DescribedTag = void;
  static constexpr std::array kRenamedKeys{RenamedKey{"place", "scene"}};

  std::string name;
  std::string description;
  std::string robot = "khr1hv";
  std::string scene = "lab";
  std::vector<PersonOptions> people;
  std::optional<CrowdEntry> crowd;
  uint64_t seed = 1;
  double duration_s = 20;
  std::optional<Eigen::Vector3d> start;
  GaitChoice gait;
  PathOptions path;
  PhysicsOptions physics;
  OmniDriveOptions drive;
  CameraOptions camera;
  SensorOptions sensors;
  std::optional<HeadScanOptions> scan;
  std::optional<KidnapOptions> kidnap;
  std::optional<LocalisationOptions> localisation;
  SystemChoice system;
  std::optional<std::string> map;
  std::optional<uint64_t> system_seed;
  VariationOptions variation;
  CalibrationErrorOptions calibration_error;
  HandicapOptions handicap;
  ScoreOptions score;
  ReportFilmOptions video;
};

template <class Visitor>
void VisitFields(Visitor& visit, Scenario& o) {
  visit("name", o.name, AnyText(), "defaults to the file's name");
  visit("description", o.description, AnyText(), "one line for people");
  visit("robot", o.robot, AnyText(), "shipped robot, or path of a robot YAML");
  visit("scene", o.scene, AnyText(), "shipped scene, or path of a scene YAML");
  visit("people", o.people, Nested(), "who walks or stands there besides the scene's own people");
  visit("crowd", o.crowd, Nested(),
        "how many more walk there to goals of their own, stand and talk, instead of the scene's own crowd");
  visit("seed", o.seed, AtLeast(0), "all randomness of the run derives from it");
  visit("duration_s", o.duration_s, Between(0, 36000),
        "the walk ends here, or when the path ends, whichever is first; 0: when the path ends");
  visit("start", o.start, Nested(), "x m, y m, yaw deg; the scene's start if absent");
  visit("gait", o.gait, Nested(), "how to walk");
  visit("path", o.path, Nested(), "where to walk");
  visit("physics", o.physics, Nested(), "MuJoCo's step, and what is off about masses and friction");
  visit("drive", o.drive, Nested(), "wheeled base, or who carries a camera: speed and vibration");
  visit("camera", o.camera, Nested(), "the head camera");
  visit("sensors", o.sensors, Nested(), "IMU, encoders");
  visit("scan", o.scan, Nested(), "how the robot looks all around when its system asks for it");
  visit("kidnap", o.kidnap, Nested(), "somebody carries the wheeled base off, and nobody tells it");
  visit("localisation", o.localisation, Nested(), "`run` recognises places on a grid instead of walking");
  visit("system", o.system, Nested(),
        "SLAM system: a name, {name: ..., setting: ...}, or somebody else's: {plugin: ...}, {process: ...}, {command: "
        "...}");
  visit("map", o.map, Nested(),
        "what the system knows beforehand: the folder of a run that learned a map, or its route.map");
  visit("system_seed", o.system_seed, Nested(), "randomness of the SLAM system alone; absent: as seed");
  visit("variation", o.variation, Nested(),
        "what differs from seed to seed as in repeats of an experiment: none, repeat, or single things");
  visit("calibration_error", o.calibration_error, Nested(),
        "what the system's calibration has wrong, drawn by seed: none, bench, or single errors");
  visit("handicap", o.handicap, Nested(), "makes the system worse on purpose, to prove a gate");
  visit("score", o.score, Nested(), "association and alignment");
  visit("video", o.video, Nested(), "the film of the report");
}

/// A scenario and all that it names, read and checked: nothing of the user's input is left to fail during the run.
struct ResolvedScenario {
  Scenario scenario;
  Robot robot;
  Scene scene;                           ///< As the seed finds it, with all people.
  std::optional<CrowdPlan> crowd;        ///< What its crowd, the last of its people, was simulated from.
  std::optional<Eigen::Vector3d> start;  ///< Of this seed: x m, y m, yaw deg; absent: as the scene says.
  std::filesystem::path file;
  std::shared_ptr<const RouteMap> map;  ///< Of `scenario.map`, if it names one.
  std::filesystem::path map_file;

  /// The whole scenario as YAML, every default written out but a `camera.renderer` that is left to the machine; reading
  /// it again gives the same run.
  std::string ToYaml() const;
  /// The same with another seed: where the scenario varies, another scene and start. @throws BadInput as ReadScenario.
  ResolvedScenario WithSeed(uint64_t seed) const;
  /// The same without a choice of who renders.
  ResolvedScenario OnAnyRenderer() const;
};

/// SHA-256 of everything that decides a run's numbers: the resolved scenario with what its robot and scene files hold,
/// and the meshes and pictures that these name, but neither names for people, nor the film, nor where files lie.
std::string HashOf(const ResolvedScenario& resolved);
/// ... that decides what the frames show: not the system, nor what it is told wrong, nor how it is scored, nor who
/// renders.
std::string FramesHashOf(const ResolvedScenario& resolved);

/// Names and values of what the seed varies, for people and files beside the truth: "start" and "[0.1, -2.2, 4]".
/// Nothing if the scenario varies nothing.
std::vector<std::pair<std::string, std::string>> VariationFacts(const ResolvedScenario& resolved);

/// Robots and scenes that were read already: making a scene's textures takes a while.
struct ModelShelf {
  std::map<std::string, Robot> robots;
  std::map<std::string, Scene> scenes;
};

/// Reads a scenario file, applies `--set` assignments in order, and resolves robot, scene and gait. A whole (`camera`)
/// may not be set after a part of it (`camera.rate_hz`), which it would take back.
/// @param shelf for those who read many scenarios of the same models.
/// @throws BadInput or BadOption with one line: file, line, column, key, value and what would be right.
ResolvedScenario ReadScenario(const std::filesystem::path& file, const std::vector<std::string>& assignments,
                              ModelShelf* shelf = nullptr);

}  // namespace gaitcam
