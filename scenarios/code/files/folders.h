/// Where the shipped robots, scenes and scenarios lie, wherever the program was started from.

#pragma once

#include <filesystem>

namespace gaitcam {

/// The folder that holds `models` and `scenarios`: $GAITCAM_DATA, else share/gaitcam of the installation, else the
/// sources.
/// @throws MissingResource if none of them is there.
std::filesystem::path DataFolder();

/// DataFolder() / "models".
std::filesystem::path ModelsFolder();

}  // namespace gaitcam
