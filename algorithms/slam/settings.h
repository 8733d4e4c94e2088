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

/// Reads every number and flag of a struct into a map; a nested struct's names carry its own and a dot before them.
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
    }
  }
};

/// The other way round, checking what a number can be.
struct SettingsApplier {
  const SystemSettings& settings;
  std::string system;  ///< For messages.
  std::string prefix;

  template <class T, class Limits>
  void operator()(std::string_view key, T& value, const Limits& limits, std::string_view) {
    if constexpr (Described<T>) {
      SettingsApplier inner{settings, system, prefix + std::string(key) + "."};
      VisitFields(inner, value);
    } else if constexpr (std::is_arithmetic_v<T>) {
      const auto entry = settings.find(prefix + std::string(key));
      if (entry != settings.end()) Apply(entry->first, entry->second, value, limits);
    }
  }

 private:
  template <class T, class Limits>
  void Apply(const std::string& name, double number, T& value, const Limits& limits) {
    const std::string field = system + "." + name;
    if constexpr (std::is_same_v<Limits, Interval>) {
      if (!limits.Contains(number)) ThrowOutOfRange(field, NumberText(number), limits.ToText());
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

/// The numbers and flags of a described struct, by name.
template <Described T>
SystemSettings SettingsOf(const T& options) {
  SystemSettings settings;
  internal::SettingsLister lister{settings, ""};
  VisitFields(lister, const_cast<T&>(options));  // the lister only reads
  return settings;
}

/// @returns T's defaults with `settings` applied.
/// @throws BadOption for an unknown name, with the nearest known one, or a value out of range.
template <Described T>
T OptionsFrom(const SystemSettings& settings, const std::string& system) {
  T options;
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
