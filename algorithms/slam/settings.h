/// A system's settings by name, put into the described options struct (algorithms/core/fields.h) that they mean.

#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/slam/system.h"

namespace gaitcam {
namespace internal {

/// Reads every number, flag and text of a struct into a map; a nested struct's names carry its own and a dot before
/// them.
struct SettingsLister {
  SystemSettings& settings;
  std::string prefix;

  template <class T, class Limits>
  void operator()(std::string_view key, T& value, const Limits&, std::string_view) {
    if constexpr (Described<T>) {
      SettingsLister inner{settings, prefix + std::string(key) + "."};
      VisitFields(inner, value);
    } else if constexpr (std::is_arithmetic_v<T>) {
      settings[prefix + std::string(key)] = double(value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      settings[prefix + std::string(key)] = value;
    }
  }
};

/// The other way round, checking what a value can be.
struct SettingsApplier {
  const SystemSettings& settings;
  std::string system;  ///< For messages.
  std::string prefix;

  template <class T, class Limits>
  void operator()(std::string_view key, T& value, const Limits& limits, std::string_view) {
    if constexpr (Described<T>) {
      SettingsApplier inner{settings, system, prefix + std::string(key) + "."};
      VisitFields(inner, value);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      const auto entry = settings.find(prefix + std::string(key));
      if (entry != settings.end()) Apply(entry->first, entry->second, value, limits);
    }
  }

 private:
  template <class Limits>
  void Apply(const std::string& name, const SettingValue& setting, std::string& value, const Limits& limits) {
    std::string permitted = "a text";
    if constexpr (std::is_same_v<Limits, Words>) permitted = limits.ToText();
    if (!setting.text()) ThrowOutOfRange(system + "." + name, setting.ToText(), permitted);
    if constexpr (std::is_same_v<Limits, Words>) {
      const std::string near = NearestWord(*setting.text(), limits.words);
      if (!near.empty()) permitted += " (did you mean " + near + "?)";
      if (!limits.Contains(*setting.text())) ThrowOutOfRange(system + "." + name, setting.ToText(), permitted);
    }
    value = *setting.text();
  }

  template <class T, class Limits>
  void Apply(const std::string& name, const SettingValue& setting, T& value, const Limits& limits) {
    const std::string field = system + "." + name;
    std::string permitted = std::is_same_v<T, bool> ? "true or false" : "a number";
    if constexpr (std::is_same_v<Limits, Interval>) permitted = limits.ToText();
    if constexpr (std::is_same_v<T, bool>) {
      if (setting.text() && (*setting.text() == "true" || *setting.text() == "false")) {
        value = *setting.text() == "true";
        return;
      }
    }
    if (!setting.number()) ThrowOutOfRange(field, setting.ToText(), permitted);
    const double number = *setting.number();
    if constexpr (std::is_same_v<Limits, Interval>) {
      if (!limits.Contains(number)) ThrowOutOfRange(field, NumberText(number), permitted);
    }
    if constexpr (std::is_same_v<T, bool>) {
      if (number != 0 && number != 1) ThrowOutOfRange(field, NumberText(number), "0 or 1");
    } else if constexpr (std::is_integral_v<T>) {
      if (number != std::floor(number)) ThrowOutOfRange(field, NumberText(number), "a whole number");
    }
    value = T(number);
  }
};

}  // namespace internal

/// The numbers, flags and texts of a described struct, by name.
template <Described T>
SystemSettings SettingsOf(const T& options) {
  SystemSettings settings;
  internal::SettingsLister lister{settings, ""};
  VisitFields(lister, const_cast<T&>(options));  // the lister only reads
  return settings;
}

/// @returns `options`, T's defaults unless given, with `settings` applied.
/// @throws BadOption for an unknown name, with the nearest known one, or a value out of range.
template <Described T>
T OptionsFrom(const SystemSettings& settings, const std::string& system, T options = T()) {
  std::vector<std::string> known;
  for (const auto& [name, value] : SettingsOf(options)) known.push_back(name);
  for (const auto& [name, value] : settings) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string near = NearestWord(name, known);
    std::string all;
    for (const std::string& word : known) all += (all.empty() ? "" : ", ") + word;
    throw BadOption(system + "." + name + ": there is no such setting; " +
                    (near.empty() ? "known: " + all : "did you mean " + near + "?"));
  }
  internal::SettingsApplier applier{settings, system, ""};
  VisitFields(applier, options);
  CheckFields(options, system + ".");
  return options;
}

}  // namespace gaitcam
