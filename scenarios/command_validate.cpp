#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scenarios/commands.h"
#include "scenarios/runner.h"
#include "scenarios/scenario.h"

namespace gaitcam {

std::vector<std::string> ScenarioArguments::Assignments() const {
  std::vector<std::string> all = sets;
  if (seed) all.push_back("seed=" + std::to_string(*seed));
  if (system) all.push_back("system=" + *system);
  return all;
}

int ValidateCommand(const ScenarioArguments& arguments, const CommonOptions& common) {
  const ResolvedScenario resolved = ReadScenario(arguments.file, arguments.Assignments());
  CheckPlan(resolved);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"valid", true}, {"scenario", resolved.scenario.name}}.dump(2));
  } else if (!common.quiet) {
    fmt::print("{}: valid; {} walks `{}` in {}, tracked by {}\n", arguments.file.string(), resolved.robot.name,
               resolved.scenario.path.kind, resolved.place.name, resolved.scenario.system.name);
  }
  return 0;
}

}  // namespace gaitcam
