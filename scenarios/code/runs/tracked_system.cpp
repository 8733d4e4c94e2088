#include "scenarios/code/runs/tracked_system.h"

#include "scenarios/code/runs/external_system.h"
#include "scenarios/code/runs/handicap.h"

namespace gaitcam {

std::unique_ptr<System> MakeTrackedSystem(const Scenario& scenario, const Calibration& calibration,
                                          const std::filesystem::path& folder) {
  const SystemSetup setup{FalsifiedCalibration(calibration, scenario.handicap),
                          scenario.system_seed.value_or(scenario.seed), scenario.system.settings};
  std::unique_ptr<System> system;
  if (scenario.system.external) {
    system = std::make_unique<ExternalSystem>(*scenario.system.external, setup, folder / "system.log");
  } else {
    system = MakeSystem(scenario.system.name, setup);
  }
  if (!IsHandicap(scenario.handicap)) return system;
  return std::make_unique<HandicappedSystem>(std::move(system), scenario.handicap, setup.seed);
}

bool ActsOnBody(const Scenario& scenario) {
  return !scenario.system.external && InfoOfSystem(scenario.system.name).acts;
}

}  // namespace gaitcam
