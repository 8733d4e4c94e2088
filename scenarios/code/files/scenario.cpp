#include "scenarios/code/files/scenario.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>

#include "algorithms/io/checksum.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/system_needs.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

void AddSettings(const OptionValue& node, const std::string& prefix, SystemSettings& settings) {
  for (const auto& entry : node.entries()) {
    const OptionValue child = node.Child(entry.key);
    if (child.IsMap()) {
      AddSettings(child, prefix + entry.key + ".", settings);
    } else if (!prefix.empty() || entry.key != "name") {
      if (!child.IsScalar()) child.Fail("expected a number or a word");
      settings[prefix + entry.key] = OptionValue(child.text());  // the system's errors name it, not the file
    }
  }
}

void WriteSetting(YAML::Emitter& out, const OptionValue& value) {
  if (const std::optional<double> number = value.AsNumber()) {
    WriteYaml(out, *number);
  } else {
    WriteYaml(out, value.text());
  }
}

}  // namespace

SystemSettings ReadSettings(const OptionValue& node) {
  SystemSettings settings;
  AddSettings(node, "", settings);
  return settings;
}

void ReadOption(const OptionValue& node, SystemChoice& value) {
  if (node.IsScalar()) {
    ReadOption(node, value.name);
    return;
  }
  if (!node.IsMap()) node.Fail("expected the name of a system, or a map {name: ..., setting: ...}");
  value.external.reset();
  if (node.Has("command")) {
    ReadOption(node, value.external.emplace());
    const std::vector<std::string>& command = value.external->command;
    if (command.empty() || command.front().empty()) node.Child("command").Fail("expected a program and its arguments");
    if (value.external->name.empty()) value.external->name = fs::path(command.front()).stem().string();
    value.name = value.external->name;
    value.settings.clear();
    return;
  }
  if (!node.Has("name")) node.Fail("expected the key `name` beside the settings, or `command`");
  ReadOption(node.Child("name"), value.name);
  value.settings = ReadSettings(node);
}

void WriteYaml(YAML::Emitter& out, const SystemChoice& value) {
  if (value.external) {
    WriteYaml(out, *value.external);
    return;
  }
  if (value.settings.empty()) {
    WriteYaml(out, value.name);
    return;
  }
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << value.name;
  for (const auto& [key, setting] : value.settings) {
    out << YAML::Key << key << YAML::Value;
    WriteSetting(out, setting);
  }
  out << YAML::EndMap;
}

namespace {

/// A name of ours stays a name; a path is meant relative to the file that says it.
std::string ResolvePath(const std::string& name_or_path, const fs::path& folder) {
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  if (!is_path || fs::path(name_or_path).is_absolute()) return name_or_path;
  const fs::path beside = folder / name_or_path;
  return fs::exists(beside) ? fs::absolute(beside).lexically_normal().string() : name_or_path;
}

/// A program with a "/" in its name is looked for beside the file, any other in PATH. Fails where it is not.
void ResolveExternal(const OptionValue& root, ExternalCommand& external) {
  const OptionValue command = root.Child("system").Child("command");
  for (const char* needed : {"{dataset}", "{output}"}) {
    const auto has = [&](const std::string& word) { return word.find(needed) != std::string::npos; };
    if (std::none_of(external.command.begin(), external.command.end(), has)) {
      command.Fail(std::string("expected ") + needed + " in one of the arguments");
    }
  }
  std::string& program = external.command.front();
  if (program.find('/') != std::string::npos) {
    program = ResolvePath(program, root.folder());
    if (access(program.c_str(), X_OK) != 0 || fs::is_directory(program)) {
      command.Element(0).Fail(program + ": there is no such program, or it may not be executed");
    }
    return;
  }
  const char* path = std::getenv("PATH");
  std::stringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((fs::path(folder) / program).c_str(), X_OK) == 0) return;
  }
  command.Element(0).Fail(program + ": there is no such program in PATH; one beside this file is written ./" + program);
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
  if (scenario.system.external) {
    ResolveExternal(root, *scenario.system.external);
    return resolved;
  }
  try {
    Calibration calibration = CameraRig(scenario.camera, scenario.seed).MakeCalibration();
    calibration.imu.rate_hz = scenario.sensors.imu_rate_hz;
    calibration.standing.emplace();  // the robot will tell; here it only matters that it can
    if (const std::optional<std::string> lack = LackInScenario(InfoOfSystem(scenario.system.name), calibration)) {
      (root.Has("system") ? root.Child("system") : root).Fail(*lack);
    }
    MakeSystem(scenario.system.name, {calibration, scenario.seed, scenario.system.settings});
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
    if (scenario.localisation) {
      scenario.localisation->methods.clear();
      scenario.localisation->wavelet = {};
      scenario.localisation->heat_maps = 0;
    }
  } else if (scenario.system.external) {
    std::string& program = scenario.system.external->command.front();
    program = fs::path(program).filename().string();
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
  for (const fs::path& file : files) text += file.empty() ? "" : "\n" + Sha256OfFile(file);
  return text;
}

}  // namespace

std::string HashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, false)); }

std::string FramesHashOf(const ResolvedScenario& resolved) { return Sha256(TextToHash(resolved, true)); }

}  // namespace gaitcam
