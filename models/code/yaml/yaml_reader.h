/// YAML files and `--set` assignments as trees of option values (algorithms/core/option_value.h).

#pragma once

#include <filesystem>
#include <string>

#include "algorithms/core/option_reader.h"
#include "algorithms/core/option_value.h"

namespace gaitcam {

/// The map that a YAML file holds; an empty file is an empty map.
/// @throws BadInput if the file cannot be read, is not YAML, or holds something other than a map.
OptionValue LoadYaml(const std::filesystem::path& file);

/// The same from a text; errors name it `name`.
OptionValue ParseYaml(const std::string& text, const std::string& name);

/// A map over another: keys of `over` replace those of `base`; where both have maps, these are laid over each other in
/// the same way. Lists and scalars are replaced whole.
OptionValue Overlay(const OptionValue& base, const OptionValue& over);

/// Replaces or adds the value at a dotted key ("gait.period_s=0.3", "path.points=[[0,0],[1,0]]"); the value is YAML.
/// @throws BadInput if `assignment` has no "=", its value is not YAML, or its key leads through something that is not a
/// map.
void SetOption(OptionValue& root, const std::string& assignment);

}  // namespace gaitcam
