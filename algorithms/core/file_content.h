/// Whole files in memory. A disk that fails in the middle of a file is told from the file's end, which a loop of
/// std::getline or `<< stream.rdbuf()` does not do: half of a scenario is a scenario, too.

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
