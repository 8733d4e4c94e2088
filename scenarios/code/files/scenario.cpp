#include "scenarios/code/files/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "algorithms/core/file_names.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/stereo_reconstruction.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/route_map_file.h"
#include "models/code/scenes/scene_crowd.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/systems/chosen_system.h"
#include "sim/walking/planned_course.h"
#include "sim/walking/walker.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

/// A name of ours stays a name; a path is meant relative to the file that says it.
std::string ResolvePath(const std::string& name_or_path, const fs::path& folder) {
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  if (!is_path || fs::path(name_or_path).is_absolute()) return name_or_path;
  const fs::path beside = folder / name_or_path;
  return IsThere(beside) ? fs::absolute(beside).lexically_normal().string() : name_or_path;
}

/// What was read before, if there is a shelf.
template <class Model>
Model FromShelf(std::map<std::string, Model>* shelf, const std::string& name,
                Model (*read)(const std::string&, const fs::path&)) {
  if (shelf == nullptr) return read(name, ModelsFolder());
  const auto there = shelf->find(name);
  return there != shelf->end() ? there->second : shelf->emplace(name, read(name, ModelsFolder())).first->second;
}

std::string Presets(const Robot& robot) {
  std::string text;
  for (const auto& [name, gait] : robot.gaits) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Starts from the robot's preset and lays the scenario's own numbers over it.
void ResolveGait(const OptionValue& root, const Robot& robot, GaitChoice& gait) {
  if (robot.kind != Robot::Kind::kHumanoid) return;
  const auto preset = robot.gaits.find(gait.preset);
  if (preset == robot.gaits.end()) {
    const OptionValue node =
        root.Has("gait") && root.Child("gait").Has("preset") ? root.Child("gait").Child("preset") : root;
    node.Fail("robot " + robot.name + " has no gait preset \"" + gait.preset + "\"; it has " + Presets(robot));
  }
  gait.options = preset->second;
  if (root.Has("gait")) ReadOption(root.Child("gait"), gait);
}

/// Before `--set system.feature=akaze` where the scenario says `system: NAME`, or nothing, and the like: the word
/// becomes a map's.
void MakeRoomForSetting(OptionValue& root, const std::string& assignment) {
  struct Block {
    std::string key, word_key, word;
  };
  static const Block kBlocks[] = {{"system", "name", SystemChoice().name},
                                  {"variation", "preset", "none"},
                                  {"calibration_error", "preset", "none"}};
  for (const auto& [key, word_key, word] : kBlocks) {
    if (!assignment.starts_with(key + ".")) continue;
    const OptionValue value = root.Has(key) ? root.Child(key) : OptionValue(word);
    if (value.IsScalar()) root.Set(key, OptionValue::Map({{word_key, value.origin(), value}}, value.origin()));
  }
}

/// Whether the robot's way can be planned: shorter steps are refused elsewhere.
bool CanPlan(const Scenario& scenario, const Robot& robot) {
  constexpr double kStep_m = 1e-3;
  return robot.kind == Robot::Kind::kOmniBase || scenario.gait.options.step_length_m > kStep_m;
}

double PathTime(const Scenario& scenario, const Robot& robot) {
  return robot.kind == Robot::Kind::kOmniBase ? EstimateDrivingTime(scenario.drive, scenario.path)
                                              : EstimateWalkingTime(scenario.gait.options, scenario.path);
}

/// How much of the path's length is walked before the time is up, at most.
double WalkedPart(const Scenario& scenario, const Robot& robot) {
  constexpr double kFaster = 1.1;  // than the estimate
  if (scenario.duration_s <= 0 || !CanPlan(scenario, robot)) return 1;
  return std::min(1.0, kFaster * scenario.duration_s / PathTime(scenario, robot));
}

/// x m, y m, yaw deg. @param start the scene's own if absent.
Eigen::Vector3d StartIn(const Scene& scene, const std::optional<Eigen::Vector3d>& start) {
  return start.value_or(Eigen::Vector3d(scene.start.x(), scene.start.y(), scene.start.z() * kDegPerRad));
}

/// x m, y m, yaw deg; nothing: as the scene says.
std::optional<Eigen::Vector3d> StartOf(const ResolvedScenario& resolved) {
  const Scenario& scenario = resolved.scenario;
  if (SaysNothing(scenario.variation) || scenario.localisation) return scenario.start;
  return StartOfSeed(StartIn(resolved.scene, scenario.start), scenario.path, WalkedPart(scenario, resolved.robot),
                     resolved.scene, scenario.variation, scenario.seed);
}

void CheckStart(const OptionValue& root, const Scenario& scenario) {
  constexpr double kFar_m = 10000;  // pictures are drawn in single precision: 1 mm is the finest there
  if (scenario.start && !(scenario.start->head<2>().cwiseAbs().maxCoeff() <= kFar_m)) {
    root.Child("start").Fail("this is far from every scene; expected x and y from -10000 to 10000 m");
  }
}

void CheckKidnap(const OptionValue& root, const ResolvedScenario& resolved) {
  const std::optional<KidnapOptions>& kidnap = resolved.scenario.kidnap;
  if (!kidnap) return;
  const OptionValue node = root.Child("kidnap");
  if (resolved.scenario.localisation) node.Fail("no robot walks beside `localisation`; expected no such block");
  if (resolved.robot.kind != Robot::Kind::kOmniBase) {
    node.Fail("robot " + resolved.robot.name + " walks; only a wheeled base can be carried off");
  }
  const Eigen::Array2d to = kidnap->to.head<2>(), low = resolved.scene.floor_min, high = resolved.scene.floor_max;
  if ((to < low).any() || (to > high).any()) {
    (node.Has("to") ? node.Child("to") : node)
        .Fail(fmt::format("expected x from {:g} to {:g} m and y from {:g} to {:g} m, on the scene's floor, and deg",
                          low.x(), high.x(), low.y(), high.y()));
  }
}

/// The crowd of this seed, if there is one. Where places are recognised on a grid, no robot walks that it could mind.
void AddCrowdOf(ResolvedScenario& resolved) {
  constexpr double kLater_s = 5;  // than planned a walk may end
  const Scenario& scenario = resolved.scenario;
  const std::optional<CrowdEntry>& crowd = scenario.crowd ? scenario.crowd : resolved.scene.crowd;
  if (!crowd || !CanPlan(scenario, resolved.robot)) return;
  RobotCourse robot;
  if (!scenario.localisation) {
    const Eigen::Vector3d start = StartIn(resolved.scene, resolved.start);
    const Pose X_WS(RotZ(start.z() * kRadPerDeg), {start.x(), start.y(), 0});
    robot = [course = PlanCourse(resolved.robot, scenario.gait.options, scenario.drive, scenario.path, X_WS)](
                double time_s) { return course(time_s).position; };
  }
  const double duration_s =
      scenario.duration_s > 0 ? scenario.duration_s : PathTime(scenario, resolved.robot) + kLater_s;
  resolved.crowd = CrowdPlan{*crowd, robot, duration_s, scenario.seed};
  AddCrowd(*resolved.crowd, resolved.scene);
}

/// Fails at `setting` within `node`, or as near to it as the file goes.
[[noreturn]] void FailAtSetting(const OptionValue& node, const std::string& setting, const std::string& message) {
  if (!setting.empty() && node.Has(setting)) node.Child(setting).Fail(message);
  const size_t dot = setting.find('.');
  const std::string group = setting.substr(0, dot);
  if (dot == std::string::npos || !node.Has(group)) node.Fail(message);
  FailAtSetting(node.Child(group), setting.substr(dot + 1), message);
}

/// Two cameras that are no rig are told here, before anything is filmed.
void CheckRig(const OptionValue& root, const Scenario& scenario) {
  if (!(scenario.camera.stereo.baseline_m > 0)) return;
  try {
    StereoRig::Of(CameraRig(scenario.camera, scenario.seed).MakeCalibration());
  } catch (const BadInput& e) {
    FailAtSetting(root.Child("camera"), "stereo", e.what());
  }
}

/// Fails where the key of the scenario stands that `message` ("camera.exposure_ms: ...") begins with, or near it.
[[noreturn]] void FailAtKey(const OptionValue& root, const std::string& message) {
  const size_t colon = message.find(": "), dot = message.find('.');
  if (colon == std::string::npos) root.Fail(message);
  const std::string key = message.substr(0, colon), group = message.substr(0, std::min(dot, colon));
  const bool is_there = root.Has(group) && (group == key || root.Child(group).Has(key.substr(group.size() + 1)));
  FailAtSetting(root, key, is_there ? message.substr(colon + 2) : message);
}

/// Fails where the setting stands that `message` ("mobif_vo.ratio: ...") names; else where the system does.
[[noreturn]] void FailAtSystem(const OptionValue& root, const std::string& message) {
  const size_t dot = message.find('.'), colon = message.find(':');
  const bool names_setting = dot < colon && colon != std::string::npos;
  FailAtSetting(root.Has("system") ? root.Child("system") : root,
                names_setting ? message.substr(dot + 1, colon - dot - 1) : "", message);
}

/// The map that the system is to know, where it takes one. @throws BadInput naming the key.
void ReadMap(const OptionValue& root, ResolvedScenario& resolved) {
  Scenario& scenario = resolved.scenario;
  MapUse use = MapUse::kNone;
  try {
    use = InfoOf(scenario.system).map;
  } catch (const BadInput& e) {
    FailAtSystem(root, e.what());
  }
  if (!scenario.map) {
    if (use != MapUse::kNeeded) return;
    root.Fail(scenario.system.name +
              " drives by a map that was learned before; set map to the folder of a run of hybrid_slam (gaitcam run "
              "scenarios/cafeteria_learn.yaml)");
  }
  const OptionValue node = root.Child("map");
  if (use == MapUse::kNone) node.Fail(scenario.system.name + " takes no map; hybrid_drive and hybrid_slam do");
  fs::path file = *scenario.map;
  if (file.is_relative() && !IsThere(file)) file = root.folder() / file;
  if (IsFolder(file)) file /= kRouteMapName;
  if (!IsThere(file))
    node.Fail("there is no map " + file.string() + "; expected the folder of a run that learned one, or its route.map");
  resolved.map_file = fs::absolute(file).lexically_normal();
  scenario.map = resolved.map_file.string();
  try {
    resolved.map = std::make_shared<const RouteMap>(ReadRouteMap(resolved.map_file));
  } catch (const BadInput& e) {
    node.Fail(e.what());
  }
}

/// `camera={exposure_ms: 20}` after `camera.rate_hz=10` would take the rate back without a word.
void CheckNoneTakesAnotherBack(const std::vector<std::string>& assignments) {
  const auto key_of = [](const std::string& assignment) { return assignment.substr(0, assignment.find('=')); };
  for (size_t i = 0; i < assignments.size(); ++i) {
    const std::string whole = key_of(assignments[i]);
    for (size_t before = 0; before < i; ++before) {
      const std::string part = key_of(assignments[before]);
      if (!part.starts_with(whole + ".")) continue;
      throw BadInput(fmt::format("--set {}: would replace all of {}, also {}, which was set before; say {} in it, too",
                                 assignments[i], whole, part, part.substr(whole.size() + 1)));
    }
  }
}

}  // namespace

ResolvedScenario ReadScenario(const fs::path& file, const std::vector<std::string>& assignments, ModelShelf* shelf) {
  CheckNoneTakesAnotherBack(assignments);
  OptionValue root = LoadYaml(file);
  for (const std::string& assignment : assignments) {
    MakeRoomForSetting(root, assignment);
    SetOption(root, assignment);
  }
  ResolvedScenario resolved;
  resolved.file = file;
  Scenario& scenario = resolved.scenario;
  ReadOption(root, scenario);
  if (scenario.name.empty()) scenario.name = file.stem().string();
  CheckFileName(root, "name", scenario.name);
  scenario.robot = ResolvePath(scenario.robot, root.folder());
  scenario.scene = ResolvePath(scenario.scene, root.folder());
  const auto fail_at = [&](const char* key, const std::exception& e) {
    (root.Has(key) ? root.Child(key) : root).Fail(e.what());
  };
  try {
    resolved.robot = FromShelf(shelf ? &shelf->robots : nullptr, scenario.robot, ReadRobot);
  } catch (const BadInput& e) {
    fail_at("robot", e);
  }
  try {
    resolved.scene = SaysNothing(scenario.variation)
                         ? FromShelf(shelf ? &shelf->scenes : nullptr, scenario.scene, ReadScene)
                         : ReadSceneOfSeed(scenario.scene, scenario.variation, scenario.seed);
  } catch (const BadInput& e) {
    fail_at("scene", e);
  }
  try {
    AddPeople(scenario.people, resolved.scene);
  } catch (const BadInput& e) {
    fail_at("people", e);
  }
  ResolveGait(root, resolved.robot, scenario.gait);
  CheckStart(root, scenario);
  CheckKidnap(root, resolved);
  try {
    Path(scenario.path, Pose());
  } catch (const BadOption& e) {
    FailAtKey(root, e.what());
  }
  try {
    resolved.start = StartOf(resolved);
  } catch (const BadInput& e) {
    fail_at("variation", e);
  }
  try {
    AddCrowdOf(resolved);
  } catch (const BadInput& e) {
    if (scenario.crowd) fail_at("crowd", e);
    fail_at("scene", BadInput("its crowd: " + std::string(e.what())));
  }
  if (scenario.localisation) {
    if (const auto problem = FindProblem(*scenario.localisation, resolved.scene))
      FailAtSetting(root.Child("localisation"), problem->key, problem->text);
    if (!SaysNothing(scenario.calibration_error))
      root.Child("calibration_error").Fail("a localisation knows none; expected no such block beside `localisation`");
  }
  Calibration calibration;
  try {
    calibration = CameraRig(scenario.camera, scenario.seed).MakeCalibration();
  } catch (const BadOption& e) {
    FailAtKey(root, e.what());
  }
  CheckRig(root, scenario);
  const OptionValue system = root.Has("system") ? root.Child("system") : root;
  ResolveFiles(system, root.folder(), scenario.system);
  ReadMap(root, resolved);
  try {
    calibration.imu.rate_hz = scenario.sensors.imu_rate_hz;
    if (scenario.sensors.odometry) calibration.odometry.rate_hz = scenario.sensors.odometry->rate_hz;
    calibration.standing.emplace();  // the robot will tell; here it only matters that it can
    if (const std::optional<std::string> lack = LackInScenario(InfoOf(scenario.system), calibration)) {
      throw BadInput(*lack);
    }
    CheckSettings(scenario.system, calibration, resolved.map);
  } catch (const BadInput& e) {
    FailAtSystem(root, e.what());
  }
  return resolved;
}

std::string ResolvedScenario::ToYaml() const {
  YAML::Emitter out;
  WriteYaml(out, scenario);
  return std::string(out.c_str()) + "\n";
}

ResolvedScenario ResolvedScenario::WithSeed(uint64_t seed) const {
  ResolvedScenario copy = *this;
  copy.scenario.seed = seed;
  if (!SaysNothing(scenario.variation)) {
    copy.scene = ReadSceneOfSeed(scenario.scene, scenario.variation, seed);
    AddPeople(scenario.people, copy.scene);
    copy.start = StartOf(copy);
  }
  AddCrowdOf(copy);
  return copy;
}

std::vector<std::pair<std::string, std::string>> VariationFacts(const ResolvedScenario& resolved) {
  if (SaysNothing(resolved.scenario.variation)) return {};
  std::vector<std::pair<std::string, std::string>> facts;
  if (resolved.start) {
    const Eigen::Vector3d& s = *resolved.start;
    facts.emplace_back("start", fmt::format("[{:.4f}, {:.4f}, {:.3f}]", s.x(), s.y(), s.z()));
  }
  facts.emplace_back("light", fmt::format("{:.4f}", resolved.scene.light));
  return facts;
}

ResolvedScenario ResolvedScenario::OnAnyRenderer() const {
  ResolvedScenario copy = *this;
  copy.scenario.camera.renderer = {};
  return copy;
}

namespace {

/// The scenario with nothing in it that is for people only or that says where files lie, and what those files hold.
std::string TextToHash(const ResolvedScenario& resolved, bool frames_only) {
  Scenario scenario = resolved.scenario;
  scenario.name = scenario.description = "";
  scenario.robot = resolved.robot.name;
  scenario.scene = resolved.scene.name;
  scenario.video = {};
  scenario.map.reset();
  for (PersonOptions& person : scenario.people) person.name = "";
  if (frames_only) {
    scenario.system = {};
    scenario.system_seed.reset();
    scenario.calibration_error = {};
    scenario.handicap = {};
    scenario.score = {};
    scenario.camera.renderer = {};
    if (scenario.localisation) {
      scenario.localisation->methods.clear();
      scenario.localisation->wavelet = {};
      scenario.localisation->heat_maps = 0;
    }
  } else {
    scenario.system = WithoutFolders(scenario.system);
  }
  YAML::Emitter out;
  WriteYaml(out, scenario);
  std::string text = out.c_str();
  std::set<fs::path> meshes;
  for (const RobotLink& link : resolved.robot.links) {
    for (const RobotShape& shape : link.visuals) meshes.insert(shape.mesh);
    for (const RobotShape& shape : link.collisions) meshes.insert(shape.mesh);
  }
  std::vector<fs::path> files{resolved.robot.yaml_file, resolved.robot.urdf_file, resolved.scene.file};
  files.insert(files.end(), resolved.scene.bases.begin(), resolved.scene.bases.end());
  files.insert(files.end(), meshes.begin(), meshes.end());
  files.insert(files.end(), resolved.scene.pictures.begin(), resolved.scene.pictures.end());
  if (!frames_only) files.push_back(resolved.map_file);
  for (const fs::path& file : files) text += file.empty() ? "" : "\n" + Sha256OfFile(file);
  return text;
}

}  // namespace

std::string HashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, false)); }

std::string FramesHashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, true)); }

}  // namespace gaitcam
