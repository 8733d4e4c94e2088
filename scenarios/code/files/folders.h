/// Where the shipped robots, scenes and scenarios lie, wherever the program was started from, and what they are called;
/// and what may be the name of a file.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algorithms/core/option_value.h"

namespace gaitcam {

/// The folder that holds `models` and `scenarios`: $GAITCAM_DATA, else share/gaitcam of the installation, else the
/// sources.
/// @throws MissingResource if none of them is there.
std::filesystem::path DataFolder();

/// DataFolder() / "models".
std::filesystem::path ModelsFolder();

/// Whether the data folder is that of an installation, where nobody writes, and not that of the sources.
bool IsInstalled();

/// The names of the YAML files in a folder of the data folder ("scenarios", "scenarios/suites"), sorted.
std::vector<std::string> ShippedNames(const std::string& folder);

/// The file that a user names: one of that path, else a shipped one, by its path in the data folder
/// ("scenarios/quickstart.yaml") or by its name ("quickstart") in one of `folders`. A path that leads nowhere is
/// returned as it is.
/// @throws BadInput for a bare name that none of the folders has, with the nearest that there is.
std::filesystem::path UsersOrShipped(const std::filesystem::path& named, const std::vector<std::string>& folders);

/// @throws BadInput at `key` of the map `node` unless `name` can be a file's or folder's name, with a little room to
/// spare for what is added to it: 1 to 100 bytes, without "/" and control characters, and not "." or "..".
void CheckFileName(const OptionValue& node, const std::string& key, const std::string& name);

}  // namespace gaitcam
