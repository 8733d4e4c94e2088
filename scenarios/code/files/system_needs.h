/// Whether a system gets the sensors that it cannot work without, known before anything is simulated or read.

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "algorithms/slam/system.h"

namespace gaitcam {

/// @param calibration as the simulated rig has it. @returns one line that names the scenario's keys to set; nothing if
/// all needs are met.
std::optional<std::string> LackInScenario(const SystemInfo& info, const Calibration& calibration);

/// Of a recorded walk, which no system that acts can steer. @param sensors the dataset's folder. @returns one line that
/// names the file and what it lacks; nothing if all needs are met.
std::optional<std::string> LackInDataset(const SystemInfo& info, const Calibration& calibration,
                                         const std::filesystem::path& sensors);

}  // namespace gaitcam
