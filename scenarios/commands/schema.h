/// JSON Schemas (draft 2020-12) of our YAML files, for editors: made from the very descriptions that the parser reads
/// by (algorithms/core/fields.h).

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "scenarios/datasets/sequence_recording.h"
#include "scenarios/experiment.h"
#include "scenarios/scenario.h"

namespace gaitcam {

using Schema = nlohmann::ordered_json;

/// The schema of a kind of file: scenario, study, suite or matrix. @throws BadInput for another name.
Schema FileSchema(const std::string& kind);

/// The kinds that there are.
std::vector<std::string> SchemaKinds();

/// What a value of a type may be. Types that read themselves (ReadYaml of their own) have an overload of their own.
Schema SchemaOf(const double&);
Schema SchemaOf(const int&);
Schema SchemaOf(const uint64_t&);
Schema SchemaOf(const bool&);
Schema SchemaOf(const std::string&);
Schema SchemaOf(const Eigen::Vector2d&);
Schema SchemaOf(const Eigen::Vector3d&);
Schema SchemaOf(const std::map<std::string, double>&);
Schema SchemaOf(const SystemChoice&);
Schema SchemaOf(const GaitChoice&);
Schema SchemaOf(const PersonOptions&);
Schema SchemaOf(const PairChoice&);
Schema SchemaOf(const Assignments&);  ///< Refers to $defs/assignments of the file's schema.
Schema SchemaOf(const Axes&);         ///< Refers to $defs/axes.
Schema SchemaOf(const Seeds&);
template <class T>
Schema SchemaOf(const std::vector<T>&);
template <class T>
Schema SchemaOf(const std::optional<T>&);
template <Described T>
Schema SchemaOf(const T& value);

namespace internal {

/// A number as JSON writes it: whole ones without a point.
Schema SchemaNumber(double value);
void AddLimits(const Interval& limits, Schema& schema);
void AddLimits(const Words& limits, Schema& schema);
inline void AddLimits(const Nested&, Schema&) {}

/// The default as JSON; null for what has none worth telling.
inline Schema DefaultOf(double value) { return SchemaNumber(value); }
inline Schema DefaultOf(int value) { return value; }
inline Schema DefaultOf(uint64_t value) { return value; }
inline Schema DefaultOf(bool value) { return value; }
inline Schema DefaultOf(const std::string& value) { return value.empty() ? Schema() : Schema(value); }
inline Schema DefaultOf(const SystemChoice& value) { return value.name; }
template <class T>
Schema DefaultOf(const std::vector<T>& values) {
  if constexpr (std::is_same_v<T, std::string> || std::is_arithmetic_v<T>) return values;
  return {};
}
template <class T>
Schema DefaultOf(const T&) {
  return {};
}

/// Writes one property per field.
struct SchemaVisitor {
  Schema properties = Schema::object();

  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits& limits, std::string_view description) {
    Schema schema = SchemaOf(static_cast<const T&>(member));
    AddLimits(limits, schema);
    schema["description"] = std::string(description);
    if (Schema value = DefaultOf(static_cast<const T&>(member)); !value.is_null()) schema["default"] = value;
    properties[std::string(key)] = std::move(schema);
  }
};

}  // namespace internal

template <class T>
Schema SchemaOf(const std::vector<T>&) {
  return {{"type", "array"}, {"items", SchemaOf(T{})}};
}

template <class T>
Schema SchemaOf(const std::optional<T>&) {
  return {{"anyOf", {SchemaOf(T{}), {{"type", "null"}}}}};
}

template <Described T>
Schema SchemaOf(const T& value) {
  internal::SchemaVisitor visitor;
  VisitFields(visitor, const_cast<T&>(value));  // the visitor only reads
  return {{"type", "object"}, {"properties", visitor.properties}, {"additionalProperties", false}};
}

}  // namespace gaitcam
