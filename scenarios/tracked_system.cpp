#include "scenarios/tracked_system.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

std::unique_ptr<System> MakeTrackedSystem(const Scenario& scenario, const Calibration& calibration,
                                          const std::filesystem::path&) {
  const uint64_t seed = scenario.system_seed.value_or(scenario.seed);
  return MakeSystem(scenario.system.name, {calibration, seed, scenario.system.settings});
}

}  // namespace gaitcam
