/// A folder that somebody else's program has filled is removed.

#pragma once

#include <filesystem>

namespace gaitcam {

/// Removes a file, or a folder with all that lies in it: however deep, and where its owner may not read it. Links are
/// not followed. (std::filesystem::remove_all holds a folder of each level open, and gives up where a process may open
/// no more; nor does it look into what it may not read.)
/// @pre nobody else writes there any more.
/// @returns false if something stays that the system does not let us remove.
bool RemoveTree(const std::filesystem::path& path);

}  // namespace gaitcam
