#include "scenarios/code/files/scenario.h"

#include <algorithm>
#include <set>

#include "algorithms/io/checksum.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

/// A name of ours stays a name; a path is meant relative to the file that says it.
std::string ResolvePath(const std::string& name_or_path, const fs::path& folder) {
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  if (!is_path || fs::path(name_or_path).is_absolute()) return name_or_path;
  const fs::path beside = folder / name_or_path;
  return fs::exists(beside) ? fs::absolute(beside).lexically_normal().string() : name_or_path;
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

/// Before `--set system.feature=akaze` where the scenario says `system: NAME`, or nothing: the name becomes a map's.
void MakeRoomForSystemSetting(OptionValue& root, const std::string& assignment) {
  if (!assignment.starts_with("system.")) return;
  const OptionValue name = root.Has("system") ? root.Child("system") : OptionValue(SystemChoice().name);
  if (name.IsScalar()) root.Set("system", OptionValue::Map({{"name", name.origin(), name}}, name.origin()));
}

/// Fails at `setting` within `node`, or as near to it as the file goes.
[[noreturn]] void FailAtSetting(const OptionValue& node, const std::string& setting, const std::string& message) {
  if (!setting.empty() && node.Has(setting)) node.Child(setting).Fail(message);
  const size_t dot = setting.find('.');
  const std::string group = setting.substr(0, dot);
  if (dot == std::string::npos || !node.Has(group)) node.Fail(message);
  FailAtSetting(node.Child(group), setting.substr(dot + 1), message);
}

/// Fails where the setting stands that `message` ("mobif_vo.ratio: ...") names; else where the system does.
[[noreturn]] void FailAtSystem(const OptionValue& root, const std::string& message) {
  const size_t dot = message.find('.'), colon = message.find(':');
  const bool names_setting = dot < colon && colon != std::string::npos;
  FailAtSetting(root.Has("system") ? root.Child("system") : root,
                names_setting ? message.substr(dot + 1, colon - dot - 1) : "", message);
}

}  // namespace

ResolvedScenario ReadScenario(const fs::path& file, const std::vector<std::string>& assignments, ModelShelf* shelf) {
  OptionValue root = LoadYaml(file);
  for (const std::string& assignment : assignments) {
    MakeRoomForSystemSetting(root, assignment);
    SetOption(root, assignment);
  }
  ResolvedScenario resolved;
  resolved.file = file;
  Scenario& scenario = resolved.scenario;
  ReadOption(root, scenario);
  if (scenario.name.empty()) scenario.name = file.stem().string();
  if (scenario.name.find('/') != std::string::npos) root.Child("name").Fail("a name must not contain \"/\"");
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
    resolved.scene = FromShelf(shelf ? &shelf->scenes : nullptr, scenario.scene, ReadScene);
  } catch (const BadInput& e) {
    fail_at("scene", e);
  }
  try {
    AddPeople(scenario.people, resolved.scene);
  } catch (const BadInput& e) {
    fail_at("people", e);
  }
  ResolveGait(root, resolved.robot, scenario.gait);
  if (scenario.localisation) {
    if (const auto problem = FindProblem(*scenario.localisation, resolved.scene))
      FailAtSetting(root.Child("localisation"), problem->key, problem->text);
  }
  const OptionValue system = root.Has("system") ? root.Child("system") : root;
  ResolveFiles(system, root.folder(), scenario.system);
  try {
    Calibration calibration = CameraRig(scenario.camera, scenario.seed).MakeCalibration();
    calibration.imu.rate_hz = scenario.sensors.imu_rate_hz;
    calibration.standing.emplace();  // the robot will tell; here it only matters that it can
    if (const std::optional<std::string> lack = LackInScenario(InfoOf(scenario.system), calibration)) {
      system.Fail(*lack);
    }
    CheckSettings(scenario.system, calibration);
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
  for (PersonOptions& person : scenario.people) person.name = "";
  if (frames_only) {
    scenario.system = {};
    scenario.system_seed.reset();
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
  files.insert(files.end(), meshes.begin(), meshes.end());
  files.insert(files.end(), resolved.scene.pictures.begin(), resolved.scene.pictures.end());
  for (const fs::path& file : files) text += file.empty() ? "" : "\n" + Sha256OfFile(file);
  return text;
}

}  // namespace

std::string HashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, false)); }

std::string FramesHashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, true)); }

}  // namespace gaitcam
