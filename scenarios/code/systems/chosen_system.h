/// The system that a choice names, whoever's it is.

#pragma once

#include <filesystem>
#include <memory>

#include "scenarios/code/systems/system_choice.h"

namespace gaitcam {

/// What is known of it without giving it a frame: of a command its name alone, of a process what the choice says.
/// @throws BadInput: there is no such system, or its library cannot be loaded.
SystemInfo InfoOf(const SystemChoice& choice);

/// @param folder where its program's output goes (system.log); it must exist.
/// @throws BadInput, BadOption: unknown or bad settings; MissingResource.
std::unique_ptr<System> MakeSystem(const SystemChoice& choice, const SystemSetup& setup,
                                   const std::filesystem::path& folder);

/// Checks the settings as far as that costs little: of ours and of a library's. @throws BadInput, BadOption.
/// @param map of a system that starts from one.
void CheckSettings(const SystemChoice& choice, const Calibration& calibration,
                   const std::shared_ptr<const RouteMap>& map = nullptr);

/// "bubblewrap", "none: bubblewrap is not installed", or "" for one of ours: how the system is kept from what is not
/// for it.
std::string SandboxOf(const SystemChoice& choice);

}  // namespace gaitcam
