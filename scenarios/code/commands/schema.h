/// JSON Schemas (draft 2020-12) of our YAML files, for editors: made from the same descriptions as the parser
/// uses (algorithms/core/fields.h).

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "scenarios/code/datasets/sequence_recording.h"
#include "scenarios/code/files/experiment.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

using Schema = nlohmann::ordered_json;

/// The schema of a kind of file: scenario, study, suite or matrix. @throws BadInput for another name.
Schema FileSchema(const std::string& kind);

/// The kinds that there are.
std::vector<std::string> SchemaKinds();

/// The schema of a type's values. Types with a ReadOption of their own have an overload of their own.
Schema SchemaOf(const double&);
Schema SchemaOf(const int&);
Schema SchemaOf(const uint64_t&);
Schema SchemaOf(const bool&);
Schema SchemaOf(const std::string&);
Schema SchemaOf(const Eigen::Vector2d&);
Schema SchemaOf(const Eigen::Vector3d&);
Schema SchemaOf(const std::map<std::string, double>&);
Schema SchemaOf(const SystemSettings&);
Schema SchemaOf(const SystemChoice&);
Schema SchemaOf(const GaitChoice&);
Schema SchemaOf(const PersonOptions&);
Schema SchemaOf(const PairChoice&);
Schema SchemaOf(const RendererChoice&);
Schema SchemaOf(const VariationOptions&);
Schema SchemaOf(const CalibrationErrorOptions&);
Schema SchemaOf(const Assignments&);  ///< Refers to $defs/assignments of the file's schema.
Schema SchemaOf(const Axes&);         ///< Refers to $defs/axes.
Schema SchemaOf(const Seeds&);
template <DescribedEnum T>
Schema SchemaOf(const T&);
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
template <DescribedEnum T>
void AddLimits(const EnumWords<T>& limits, Schema& schema) {
  AddLimits(AsWords(limits), schema);
}
inline void AddLimits(const Nested&, Schema&) {}

/// The default as JSON; null where there is none to show.
inline Schema DefaultOf(double value) { return SchemaNumber(value); }
inline Schema DefaultOf(int value) { return value; }
inline Schema DefaultOf(uint64_t value) { return value; }
inline Schema DefaultOf(bool value) { return value; }
inline Schema DefaultOf(const std::string& value) { return value.empty() ? Schema() : Schema(value); }
inline Schema DefaultOf(const SystemChoice& value) { return value.name; }
inline Schema DefaultOf(const RendererChoice& value) { return value.ToText(); }
inline Schema DefaultOf(const VariationOptions& value) { return std::string(ToWord(value.preset)); }
inline Schema DefaultOf(const CalibrationErrorOptions& value) { return std::string(ToWord(value.preset)); }
template <class T>
Schema DefaultOf(const std::vector<T>& values) {
  if constexpr (std::is_same_v<T, std::string> || std::is_arithmetic_v<T>) return values;
  if constexpr (DescribedEnum<T>) {
    Schema words = Schema::array();
    for (const T value : values) words.push_back(std::string(ToWord(value)));
    return words;
  }
  return {};
}
template <class T>
Schema DefaultOf(const T& value) {
  if constexpr (DescribedEnum<T>) return DefaultOf(std::string(ToWord(value)));
  return {};
}

/// "shutter open to close [ms]"
inline std::string WithUnit(std::string_view description, std::string_view unit) {
  return std::string(description) + (unit.empty() ? "" : " [" + std::string(unit) + "]");
}

/// Writes one property per field.
struct SchemaVisitor {
  Schema properties = Schema::object();

  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits& limits, std::string_view description) {
    Schema schema = SchemaOf(static_cast<const T&>(member));
    AddLimits(limits, schema);
    schema["description"] = internal::WithUnit(description, UnitOfKey(key));
    if (Schema value = DefaultOf(static_cast<const T&>(member)); !value.is_null()) schema["default"] = value;
    properties[std::string(key)] = std::move(schema);
  }
};

}  // namespace internal

template <DescribedEnum T>
Schema SchemaOf(const T&) {
  return {{"type", "string"}};
}

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
