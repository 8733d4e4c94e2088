#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "algorithms/core/fields.h"
#include "algorithms/slam/system.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace {

std::vector<std::string> ListScenarios() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(DataFolder() / "scenarios")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

nlohmann::ordered_json JsonOf(const FieldInfo& option) {
  nlohmann::ordered_json json;
  const OptionValue& value = option.default_value;
  if (const std::optional<double> number = value.AsNumber()) {
    json["default"] = *number;
  } else if (option.permitted == "true or false") {
    json["default"] = *value.AsFlag();
  } else {
    json["default"] = value.text();
  }
  if (!option.unit.empty()) json["unit"] = option.unit;
  json["permitted"] = option.permitted;
  if (!option.words.empty()) json["words"] = option.words;
  json["description"] = option.description;
  return json;
}

nlohmann::ordered_json JsonOf(const SystemInfo& system) {
  nlohmann::ordered_json json{{"description", system.description}, {"needs", nlohmann::ordered_json::array()}};
  for (const SensorNeed need : system.needs) json["needs"].push_back(ToString(need));
  json["acts"] = system.acts;
  json["options"] = nlohmann::ordered_json::object();
  for (const FieldInfo& option : system.options) json["options"][option.key] = JsonOf(option);
  return json;
}

/// "ratio = 0.8 (a number from 0.1 to 1): best over second-best distance".
std::string OptionText(const std::string& name, const nlohmann::ordered_json& option) {
  const auto& value = option["default"];
  std::string text = name + " = ";
  text += value.is_number()   ? fmt::format("{:g}", value.get<double>())
          : value.is_string() ? value.get<std::string>()
                              : value.dump();
  if (option.contains("unit")) text += " " + option["unit"].get<std::string>();
  text += " (" + option["permitted"].get<std::string>() + ")";
  const std::string description = option["description"].get<std::string>();
  return description.empty() ? text : text + ": " + description;
}

nlohmann::ordered_json Everything() {
  nlohmann::ordered_json all;
  for (const std::string& name : ListRobots(ModelsFolder())) {
    const Robot robot = ReadRobot(name, ModelsFolder());
    std::vector<std::string> gaits;
    for (const auto& [gait, options] : robot.gaits) gaits.push_back(gait);
    all["robots"][name] = {{"mass_kg", robot.TotalMass()}, {"gaits", gaits}};
  }
  all["scenes"] = ListScenes(ModelsFolder());
  for (const SystemInfo& system : ListSystems()) all["systems"][system.name] = JsonOf(system);
  all["scenarios"] = ListScenarios();
  return all;
}

void Print(const nlohmann::ordered_json& all) {
  fmt::print("Robots\n");
  for (const auto& [name, robot] : all["robots"].items()) {
    std::string gaits;
    for (const auto& gait : robot["gaits"]) gaits += (gaits.empty() ? "gaits " : ", ") + gait.get<std::string>();
    fmt::print("  {:<16} {:.2f} kg  {}\n", name, robot["mass_kg"].get<double>(), gaits);
  }
  fmt::print("Scenes\n");
  for (const auto& scene : all["scenes"]) fmt::print("  {}\n", scene.get<std::string>());
  fmt::print("Systems\n");
  for (const auto& [name, system] : all["systems"].items()) {
    fmt::print("  {:<16} {}\n", name, system["description"].get<std::string>());
    std::string needs;
    for (const auto& need : system["needs"]) needs += (needs.empty() ? "" : ", ") + need.get<std::string>();
    if (!needs.empty()) fmt::print("  {:<16} needs {}\n", "", needs);
    if (system["acts"].get<bool>()) fmt::print("  {:<16} commands the robot\n", "");
    for (const auto& [key, option] : system["options"].items()) {
      fmt::print("  {:<16}   {}\n", "", OptionText(key, option));
    }
  }
  fmt::print("Scenarios\n");
  for (const auto& scenario : all["scenarios"]) fmt::print("  scenarios/{}.yaml\n", scenario.get<std::string>());
}

}  // namespace

int ListCommand(const CommonOptions& common) {
  const nlohmann::ordered_json all = Everything();
  if (common.json) {
    fmt::print("{}\n", all.dump(2));
  } else {
    Print(all);
  }
  return 0;
}

}  // namespace gaitcam
