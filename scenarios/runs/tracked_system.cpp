#include "scenarios/runs/tracked_system.h"

#include "scenarios/runs/external_system.h"
#include "scenarios/runs/handicap.h"

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
  if (scenario.system.external) return false;
  Calibration calibration = CameraRig(scenario.camera, scenario.seed).MakeCalibration();
  calibration.standing.emplace();  // the robot will tell; here it only matters that it can
  return MakeSystem(scenario.system.name, {calibration, scenario.seed, scenario.system.settings})->Acts();
}

}  // namespace gaitcam
