/// The manual page gaitcam(1), written from what --help says.

#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace gaitcam {

/// Source for man: all verbs with their options and examples. The same program gives the same bytes.
std::string ManualPage(const CLI::App& app, const std::string& version);

}  // namespace gaitcam
