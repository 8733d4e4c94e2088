#include "scenarios/code/runs/tracked_system.h"

#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/handicap.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {

std::unique_ptr<System> MakeTrackedSystem(const ResolvedScenario& resolved, const Calibration& calibration,
                                          const std::filesystem::path& folder) {
  const Scenario& scenario = resolved.scenario;
  const CalibrationError error = DrawCalibrationError(scenario.calibration_error, resolved.robot, scenario.seed);
  const SystemSetup setup{FalsifiedCalibration(Miscalibrated(calibration, error), scenario.handicap),
                          scenario.system_seed.value_or(scenario.seed), scenario.system.settings, resolved.map};
  std::unique_ptr<System> system = MakeSystem(scenario.system, setup, folder);
  if (IsHandicap(scenario.handicap)) {
    system = std::make_unique<HandicappedSystem>(std::move(system), scenario.handicap, setup.seed);
  }
  if (SaysNothing(scenario.calibration_error)) return system;
  return std::make_unique<MiscalibratedSystem>(
      std::move(system), MiscalibratedSensors(error, resolved.robot, scenario.seed, calibration.odometry.rate_hz));
}

bool ActsOnBody(const Scenario& scenario) { return InfoOf(scenario.system).acts; }

}  // namespace gaitcam
