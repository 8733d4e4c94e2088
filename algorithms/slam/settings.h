/// A system's settings, put into the described options struct (algorithms/core/fields.h) that they mean.

#pragma once

#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/field_list.h"
#include "algorithms/core/option_reader.h"
#include "algorithms/slam/system.h"

namespace gaitcam {

/// The numbers, flags, words and texts of a described struct, by name; those of a nested struct are named with a dot.
template <Described T>
SystemSettings SettingsOf(const T& options) {
  SystemSettings settings;
  for (const FieldInfo& field : ListFields(options)) settings[field.key] = field.default_value;
  return settings;
}

/// @returns `options`, T's defaults unless given, with `settings` applied.
/// @throws BadOption for an unknown name, with the nearest known one, or a value out of range ("mobif_vo.ratio: ...").
template <Described T>
T OptionsFrom(const SystemSettings& settings, const std::string& system, T options = T()) {
  try {
    OptionValue tree = OptionValue::Map({}, {}).WithPath(system);
    for (const auto& [name, value] : settings) tree.Set(name, value);
    ReadOption(tree, options);
  } catch (const BadInput& e) {
    throw BadOption(e.what());
  }
  CheckFields(options, system + ".");
  return options;
}

}  // namespace gaitcam
