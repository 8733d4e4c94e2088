/// The SLAM system that a scenario names, ready to be given frames, whoever's it is; with its handicap, if it has one.

#pragma once

#include <filesystem>
#include <memory>

#include "scenarios/code/files/scenario.h"

namespace gaitcam {

/// The one place where a calibration and observations are handed to a system: what the scenario's calibration has wrong
/// (calibration_error.h), and a handicap, come in between.
/// @param calibration as the rig has it.
/// @param folder where the captured output of somebody else's goes (system.log); it must exist.
/// @throws BadInput, BadOption as MakeSystem does.
std::unique_ptr<System> MakeTrackedSystem(const ResolvedScenario& resolved, const Calibration& calibration,
                                          const std::filesystem::path& folder);

/// Whether that system commands the body: then its walk is its own, and no recorded one is for it.
bool ActsOnBody(const Scenario& scenario);

}  // namespace gaitcam
