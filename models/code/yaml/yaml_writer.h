/// Described structs (algorithms/core/fields.h) and option values as YAML; reading the text again gives the same
/// values.

#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/option_value.h"

namespace gaitcam {

/// Writes one value; a type with rules of its own provides `void WriteYaml(YAML::Emitter&, const T&)` in its namespace.
/// Numbers are written with the fewest digits that read back to the same bits.
void WriteYaml(YAML::Emitter& out, double value);
void WriteYaml(YAML::Emitter& out, int value);
void WriteYaml(YAML::Emitter& out, uint64_t value);
void WriteYaml(YAML::Emitter& out, bool value);
void WriteYaml(YAML::Emitter& out, const std::string& value);
void WriteYaml(YAML::Emitter& out, const Eigen::Vector2d& value);
void WriteYaml(YAML::Emitter& out, const Eigen::Vector3d& value);
void WriteYaml(YAML::Emitter& out, const std::map<std::string, double>& value);
void WriteYaml(YAML::Emitter& out, const OptionValue& value);
template <class T>
void WriteYaml(YAML::Emitter& out, const std::vector<T>& value);
template <class T>
void WriteYaml(YAML::Emitter& out, const std::optional<T>& value);
template <DescribedEnum T>
void WriteYaml(YAML::Emitter& out, const T& value);
template <Described T>
void WriteYaml(YAML::Emitter& out, const T& value);

namespace internal {

/// An empty list of described structs, an absent struct, number or text are not written. A type with rules of its
/// own may provide `bool SaysNothing(const T&)` in its namespace.
template <class T>
bool SaysNothing(const T&) {
  return false;
}
template <Described T>
bool SaysNothing(const std::vector<T>& values) {
  return values.empty();
}
template <Described T>
bool SaysNothing(const std::optional<T>& value) {
  return !value;
}
inline bool SaysNothing(const std::optional<double>& value) { return !value; }
inline bool SaysNothing(const std::optional<std::string>& value) { return !value; }

struct YamlFieldWriter {
  YAML::Emitter& out;
  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits&, std::string_view) {
    if (SaysNothing(member)) return;
    out << YAML::Key << std::string(key) << YAML::Value;
    WriteYaml(out, static_cast<const T&>(member));
  }
};

}  // namespace internal

template <DescribedEnum T>
void WriteYaml(YAML::Emitter& out, const T& value) {
  WriteYaml(out, std::string(ToWord(value)));
}

template <Described T>
void WriteYaml(YAML::Emitter& out, const T& value) {
  out << YAML::BeginMap;
  internal::YamlFieldWriter writer{out};
  VisitFields(writer, const_cast<T&>(value));  // the writer only reads
  out << YAML::EndMap;
}

template <class T>
void WriteYaml(YAML::Emitter& out, const std::vector<T>& value) {
  if constexpr (!Described<T>) out << YAML::Flow;
  out << YAML::BeginSeq;
  for (const T& element : value) WriteYaml(out, element);
  out << YAML::EndSeq;
}

template <class T>
void WriteYaml(YAML::Emitter& out, const std::optional<T>& value) {
  if (value) {
    WriteYaml(out, *value);
  } else {
    out << YAML::Null;
  }
}

}  // namespace gaitcam
