#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "algorithms/slam/system.h"
#include "models/place.h"
#include "models/robot.h"
#include "scenarios/commands/commands.h"
#include "scenarios/folders.h"

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

nlohmann::ordered_json Everything() {
  nlohmann::ordered_json all;
  for (const std::string& name : ListRobots(ModelsFolder())) {
    const Robot robot = ReadRobot(name, ModelsFolder());
    std::vector<std::string> gaits;
    for (const auto& [gait, options] : robot.gaits) gaits.push_back(gait);
    all["robots"][name] = {{"mass_kg", robot.TotalMass()}, {"gaits", gaits}};
  }
  all["places"] = ListPlaces(ModelsFolder());
  for (const SystemInfo& system : ListSystems()) {
    nlohmann::ordered_json settings;
    for (const auto& [key, value] : system.defaults) {
      settings[key] = value.number() ? nlohmann::ordered_json(*value.number()) : nlohmann::ordered_json(*value.text());
    }
    all["systems"][system.name] = {{"description", system.description}, {"settings", settings}};
  }
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
  fmt::print("Places\n");
  for (const auto& place : all["places"]) fmt::print("  {}\n", place.get<std::string>());
  fmt::print("Systems\n");
  for (const auto& [name, system] : all["systems"].items()) {
    fmt::print("  {:<16} {}\n", name, system["description"].get<std::string>());
    for (const auto& [key, value] : system["settings"].items()) {
      fmt::print("  {:<16}   {} = {}\n", "", key,
                 value.is_number() ? fmt::format("{:g}", value.get<double>()) : value.get<std::string>());
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
