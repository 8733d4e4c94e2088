/// Reads described structs (fields.h) from trees of option values: the one way in for files, `--set` and settings.
///
/// Absent keys keep the struct's values. A key that the struct does not have, a value of the wrong kind and one outside
/// its limits are refused with one line that names where the value was written, and what would be right.

#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/option_value.h"

namespace gaitcam {

/// Reads one value; overloads exist for the member types that described structs use. A type with rules of its own
/// provides `void ReadOption(const OptionValue&, T&)` in its namespace.
/// @throws BadInput; BadOption for a number or word outside its limits.
void ReadOption(const OptionValue& node, double& value);
void ReadOption(const OptionValue& node, int& value);
void ReadOption(const OptionValue& node, uint64_t& value);
void ReadOption(const OptionValue& node, bool& value);
void ReadOption(const OptionValue& node, std::string& value);
void ReadOption(const OptionValue& node, Eigen::Vector2d& value);
void ReadOption(const OptionValue& node, Eigen::Vector3d& value);
void ReadOption(const OptionValue& node, std::map<std::string, double>& value);
template <class T>
void ReadOption(const OptionValue& node, std::vector<T>& value);
template <class T>
void ReadOption(const OptionValue& node, std::optional<T>& value);
template <DescribedEnum T>
void ReadOption(const OptionValue& node, T& value);
template <Described T>
void ReadOption(const OptionValue& node, T& value);

/// Numbers and words within limits.
void ReadOption(const OptionValue& node, double& value, const Interval& limits);
void ReadOption(const OptionValue& node, int& value, const Interval& limits);
void ReadOption(const OptionValue& node, uint64_t& value, const Interval& limits);
void ReadOption(const OptionValue& node, std::string& value, const Words& limits);

/// A key's former name. A struct that has renamed keys says so by a member
/// `static constexpr std::array kRenamedKeys{RenamedKey{"old", "new"}};`.
struct RenamedKey {
  std::string_view old_key, new_key;
};

/// @throws BadInput naming the first key of the map `node` that is not in `known`, with the nearest that is or the name
/// that it has now; or a key that is given twice.
void RefuseUnknownKeys(const OptionValue& node, const std::vector<std::string>& known,
                       const std::vector<RenamedKey>& renamed = {});

namespace internal {

struct KeyCollector {
  std::vector<std::string> keys;
  template <class T, class Limits>
  void operator()(std::string_view key, T&, const Limits&, std::string_view) {
    keys.emplace_back(key);
  }
};

/// Sets the members whose keys are present.
struct FieldReader {
  const OptionValue& map;

  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits& limits, std::string_view) {
    const std::string name(key);
    if (!map.Has(name)) return;
    if constexpr (std::is_same_v<Limits, Interval> || std::is_same_v<Limits, Words>) {
      ReadOption(map.Child(name), member, limits);
    } else {
      ReadOption(map.Child(name), member);
    }
  }
};

}  // namespace internal

/// The keys that a described struct reads, in order.
template <Described T>
std::vector<std::string> FieldKeys() {
  internal::KeyCollector collector;
  T value;
  VisitFields(collector, value);
  return collector.keys;
}

/// Sets the members of `value` whose keys `node` has. @throws BadInput
template <Described T>
void ReadFields(const OptionValue& node, T& value) {
  std::vector<RenamedKey> renamed;
  if constexpr (requires { T::kRenamedKeys; }) renamed.assign(T::kRenamedKeys.begin(), T::kRenamedKeys.end());
  RefuseUnknownKeys(node, FieldKeys<T>(), renamed);
  internal::FieldReader reader{node};
  VisitFields(reader, value);
}

template <DescribedEnum T>
void ReadOption(const OptionValue& node, T& value) {
  std::string word;
  ReadOption(node, word, AsWords(EnumWords<T>()));
  value = *FromWord<T>(word);
}

template <Described T>
void ReadOption(const OptionValue& node, T& value) {
  ReadFields(node, value);
}

template <class T>
void ReadOption(const OptionValue& node, std::vector<T>& value) {
  if (!node.IsList()) node.Fail("expected a list");
  value.assign(node.size(), T{});
  for (size_t i = 0; i < value.size(); ++i) ReadOption(node.Element(i), value[i]);
}

template <class T>
void ReadOption(const OptionValue& node, std::optional<T>& value) {
  value.emplace();
  ReadOption(node, *value);
}

}  // namespace gaitcam
