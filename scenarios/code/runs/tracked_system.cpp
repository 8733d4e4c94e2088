#include "scenarios/code/runs/tracked_system.h"

#include "scenarios/code/runs/handicap.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {

std::unique_ptr<System> MakeTrackedSystem(const Scenario& scenario, const Calibration& calibration,
                                          const std::filesystem::path& folder) {
  const SystemSetup setup{FalsifiedCalibration(calibration, scenario.handicap),
                          scenario.system_seed.value_or(scenario.seed), scenario.system.settings};
  std::unique_ptr<System> system = MakeSystem(scenario.system, setup, folder);
  if (!IsHandicap(scenario.handicap)) return system;
  return std::make_unique<HandicappedSystem>(std::move(system), scenario.handicap, setup.seed);
}

bool ActsOnBody(const Scenario& scenario) { return InfoOf(scenario.system).acts; }

}  // namespace gaitcam
