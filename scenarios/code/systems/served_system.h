/// The other side of frame_protocol.h: a System of ours, or of a shared library, that answers the lines of whoever
/// started this program. That is how a library's crash stays the library's.

#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "algorithms/slam/plugin.h"

namespace gaitcam {

/// Loads the library; it stays loaded. @throws BadInput: it cannot be loaded, offers no system, or was built with other
/// headers.
const SystemPlugin& LoadPlugin(const std::filesystem::path& library);

/// Answers the lines of standard input until it ends or "finish" was answered. What the system prints to standard
/// output goes to standard error.
/// @returns the exit code: 0, or 1 if the system threw.
int ServeSystem(const std::function<std::unique_ptr<System>(const SystemSetup&)>& make, bool acts);

/// What is known of a library's system, asked of a process that loads it; asked once for each state of the file.
/// @param readable what that process may see of the user's files: the library and what it depends on
/// @throws BadInput with its words if it cannot be loaded.
SystemInfo AskPluginInfo(const std::filesystem::path& library, const std::vector<std::filesystem::path>& readable);
/// What that process prints.
std::string PluginInfoText(const SystemInfo& info);

/// The words that serve a library's system.
std::vector<std::string> WordsToServe(const std::filesystem::path& library);

}  // namespace gaitcam
