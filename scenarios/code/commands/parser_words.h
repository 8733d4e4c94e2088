/// What the parser of the command line knows by name: verbs, options, and what stands in their place when a user slips.

#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace gaitcam {

/// The verbs that --help shows.
std::vector<const CLI::App*> VisibleVerbs(const CLI::App& app);

/// A verb by its name, hidden ones included; null if there is none.
const CLI::App* FindVerb(const CLI::App& app, const std::string& name);

/// Options that are shown, as they are typed ("--seed", "-j"), those of every verb included.
std::vector<std::string> OptionNames(const CLI::App& app, const CLI::App& verb);

/// "rnu: no such verb; did you mean run?"
std::string NoSuchVerb(const CLI::App& app, const std::string& word);

/// The verb that `words` ask for, if there is none of that name.
std::optional<std::string> UnknownVerb(const CLI::App& app, const std::vector<std::string>& words);

/// "see gaitcam help run" after a verb was understood, else "see gaitcam --help".
std::string WhereToLook(const CLI::App& app);

/// Why the parser, after parsing, could do nothing with a word: "run: there is no option --sed; did you mean --seed?"
std::string UnexpectedWord(const CLI::App& app);

/// Folders of the data folder whose files a verb takes by their bare names.
std::vector<std::string> ShippedFoldersOf(const std::string& verb);

}  // namespace gaitcam
