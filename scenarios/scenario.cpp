#include "scenarios/scenario.h"

#include "scenarios/folders.h"

namespace gaitcam {
namespace fs = std::filesystem;

void ReadYaml(const YamlNode& node, SystemChoice& value) {
  if (node.node().IsScalar()) {
    ReadYaml(node, value.name);
    return;
  }
  if (!node.node().IsMap()) node.Fail("expected the name of a system, or a map {name: ..., setting: ...}");
  if (!node.Has("name")) node.Fail("expected the key `name` beside the settings");
  value.settings.clear();
  for (const auto& entry : node.node()) {
    const std::string key = entry.first.Scalar();
    if (key == "name") {
      ReadYaml(node.Child(key), value.name);
    } else {
      ReadYaml(node.Child(key), value.settings[key]);
    }
  }
}

void WriteYaml(YAML::Emitter& out, const SystemChoice& value) {
  if (value.settings.empty()) {
    WriteYaml(out, value.name);
    return;
  }
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << value.name;
  for (const auto& [key, number] : value.settings) {
    out << YAML::Key << key << YAML::Value;
    WriteYaml(out, number);
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

std::string Presets(const Robot& robot) {
  std::string text;
  for (const auto& [name, gait] : robot.gaits) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Starts from the robot's preset and lays the scenario's own numbers over it.
void ResolveGait(const YamlNode& root, const Robot& robot, GaitChoice& gait) {
  if (robot.kind != Robot::Kind::kHumanoid) return;
  const auto preset = robot.gaits.find(gait.preset);
  if (preset == robot.gaits.end()) {
    const YamlNode node =
        root.Has("gait") && root.Child("gait").Has("preset") ? root.Child("gait").Child("preset") : root;
    node.Fail("robot " + robot.name + " has no gait preset \"" + gait.preset + "\"; it has " + Presets(robot));
  }
  gait.options = preset->second;
  if (root.Has("gait")) ReadYaml(root.Child("gait"), gait);
}

}  // namespace

ResolvedScenario ReadScenario(const fs::path& file, const std::vector<std::string>& assignments) {
  YamlNode root = YamlNode::LoadFile(file);
  for (const std::string& assignment : assignments) root.Set(assignment);
  ResolvedScenario resolved;
  resolved.file = file;
  Scenario& scenario = resolved.scenario;
  ReadYaml(root, scenario);
  if (scenario.name.empty()) scenario.name = file.stem().string();
  if (scenario.name.find('/') != std::string::npos) root.Child("name").Fail("a name must not contain \"/\"");
  scenario.robot = ResolvePath(scenario.robot, root.folder());
  scenario.place = ResolvePath(scenario.place, root.folder());
  const auto fail_at = [&](const char* key, const std::exception& e) {
    (root.Has(key) ? root.Child(key) : root).Fail(e.what());
  };
  try {
    resolved.robot = ReadRobot(scenario.robot, ModelsFolder());
  } catch (const BadInput& e) {
    fail_at("robot", e);
  }
  try {
    resolved.place = ReadPlace(scenario.place, ModelsFolder());
  } catch (const BadInput& e) {
    fail_at("place", e);
  }
  ResolveGait(root, resolved.robot, scenario.gait);
  try {
    MakeSystem(scenario.system.name,
               {CameraRig(scenario.camera, scenario.seed).MakeCalibration(), scenario.seed, scenario.system.settings});
  } catch (const BadInput& e) {
    fail_at("system", e);
  }
  return resolved;
}

std::string ResolvedScenario::ToYaml() const {
  YAML::Emitter out;
  WriteYaml(out, scenario);
  return std::string(out.c_str()) + "\n";
}

}  // namespace gaitcam
