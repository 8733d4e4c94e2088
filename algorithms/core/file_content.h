/// Whole files in memory. A read that fails half-way is an error here. A loop of std::getline and `<< stream.rdbuf()`
/// take it for the end of the file, and half of a scenario is a valid scenario.

#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace gaitcam {

/// All bytes of a file, as they are. @throws BadInput "FILE: cannot read this file" if it is a folder, or is not there
/// or may not be read, "FILE: reading broke off after N bytes" if it cannot be read to its end.
std::string FileContent(const std::filesystem::path& file);

/// The same; nothing if there is no such file.
std::optional<std::string> FindFileContent(const std::filesystem::path& file);

}  // namespace gaitcam
