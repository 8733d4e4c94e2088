/// Completion of the command line, which shells ask for (scenarios/code/package/completion.bash).

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace gaitcam {

/// What the last of `words` may become: verbs, options, values of options, names of what is shipped. None where any
/// file may stand. @param words those after the program's name; the last one is being typed and may be empty.
std::vector<std::string> Completions(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace gaitcam
