#include "scenarios/code/commands/schema.h"

#include <set>

#include "scenarios/code/datasets/record_matrix.h"
#include "scenarios/code/jobs/study.h"
#include "scenarios/code/jobs/suite.h"

namespace gaitcam {
namespace {

Schema Reference(const std::string& pointer) { return {{"$ref", "#/$defs/" + pointer}}; }

Schema Vector(int size) {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", size}, {"maxItems", size}};
}

/// One value of a system's setting: a number or a word; a group of settings is a map.
Schema SettingSchema() { return {{"type", {"number", "string", "boolean"}}}; }

/// A setting by its dotted key, and as a map within maps.
void AddSetting(Schema& properties, const std::string& key) {
  properties[key] = SettingSchema();
  const size_t dot = key.find('.');
  if (dot == std::string::npos) return;
  Schema& group = properties[key.substr(0, dot)];
  group["type"] = "object";
  group["additionalProperties"] = false;
  AddSetting(group["properties"], key.substr(dot + 1));
}

/// `{name: mobif_vo, ratio: 0.8, matching: {mutual: 1}}`: the settings of all systems together.
Schema NamedSystemSchema() {
  Schema properties{{"name", {{"enum", Schema::array()}, {"description", "one of our systems"}}}};
  std::map<std::string, std::string> owners;
  for (const SystemInfo& system : ListSystems()) {
    properties["name"]["enum"].push_back(system.name);
    for (const auto& [key, value] : system.Defaults()) {
      owners[key] += (owners[key].empty() ? "of " : ", ") + system.name;
    }
  }
  for (const auto& [key, owner] : owners) {
    AddSetting(properties, key);
    properties[key]["description"] = owner;
  }
  return {{"type", "object"}, {"properties", properties}, {"required", {"name"}}, {"additionalProperties", false}};
}

/// The keys of a scenario with their dots, each with where its schema stands: "camera.exposure_ms".
void AddDottedKeys(const Schema& schema, const std::string& prefix, const std::string& pointer, Schema& keys) {
  if (schema.contains("anyOf") && prefix != "system.") {  // a block that may also be a word, or nothing
    for (size_t i = 0; i < schema["anyOf"].size(); ++i)
      AddDottedKeys(schema["anyOf"][i], prefix, pointer + "/anyOf/" + std::to_string(i), keys);
  }
  if (!schema.contains("properties")) return;
  for (const auto& [key, property] : schema["properties"].items()) {
    const std::string here = pointer + "/properties/" + key;
    keys[prefix + key] = Reference(here);
    AddDottedKeys(property, prefix + key + ".", here, keys);
  }
}

/// Definitions shared by studies and matrices: the scenario, keys with values, keys with lists of values.
Schema ExperimentDefinitions() {
  const Schema scenario = SchemaOf(Scenario());
  Schema keys = Schema::object(), axes = Schema::object();
  AddDottedKeys(scenario, "", "scenario", keys);
  for (const auto& [key, reference] : keys.items())
    axes[key] = {{"type", "array"}, {"items", reference}, {"minItems", 1}, {"uniqueItems", true}};
  const Schema settings{{"type", "array"}, {"items", SettingSchema()}, {"minItems", 1}, {"uniqueItems", true}};
  Schema definitions;
  definitions["scenario"] = scenario;
  definitions["assignments"] = {{"type", "object"},
                                {"properties", keys},
                                {"patternProperties", {{"^system\\.", SettingSchema()}}},
                                {"additionalProperties", false}};
  definitions["axes"] = {{"type", "object"},
                         {"properties", axes},
                         {"patternProperties", {{"^system\\.", settings}}},
                         {"additionalProperties", false},
                         {"minProperties", 1}};
  return definitions;
}

/// A study or a matrix: an experiment with further keys.
Schema ExperimentSchema(Schema schema, bool must_vary) {
  schema["properties"]["list"]["minItems"] = 1;
  schema["required"] = {"base"};
  const Schema axes{{"required", {"axes"}}}, list{{"required", {"list"}}};
  if (must_vary) {
    schema["oneOf"] = {axes, list};
  } else {
    schema["not"] = {{"required", {"axes", "list"}}};
  }
  schema["$defs"] = ExperimentDefinitions();
  return schema;
}

Schema SuiteSchema() {
  Schema schema = SchemaOf(SuiteOptions());
  schema["required"] = {"scenarios", "systems", "seeds", "metrics"};
  for (const char* key : {"scenarios", "systems", "metrics"}) schema["properties"][key]["minItems"] = 1;
  schema["$defs"] = ExperimentDefinitions();
  return schema;
}

/// A preset's word, or a map of keys that differ from one (preset_block.h).
template <class Block>
Schema PresetBlockSchema(const Block& block) {
  internal::SchemaVisitor visitor;
  VisitFields(visitor, const_cast<Block&>(block));  // the visitor only reads
  const Schema word{{"type", "string"}, {"enum", visitor.properties["preset"]["enum"]}};
  return {{"anyOf", {word, {{"type", "object"}, {"properties", visitor.properties}, {"additionalProperties", false}}}}};
}

template <class T>
Schema FieldsSchema() {  // a struct that only inherits its tag
  return SchemaOf(T());
}

}  // namespace

namespace internal {

Schema SchemaNumber(double value) {
  if (std::abs(value) < 1e15 && value == std::floor(value)) return int64_t(value);
  return value;
}

void AddLimits(const Interval& limits, Schema& schema) {
  if (std::isfinite(limits.low)) schema[limits.low_open ? "exclusiveMinimum" : "minimum"] = SchemaNumber(limits.low);
  if (std::isfinite(limits.high)) schema["maximum"] = SchemaNumber(limits.high);
}

void AddLimits(const Words& limits, Schema& schema) {
  if (!limits.words.empty()) schema["enum"] = limits.words;
}

}  // namespace internal

Schema SchemaOf(const double&) { return {{"type", "number"}}; }
Schema SchemaOf(const int&) { return {{"type", "integer"}}; }
Schema SchemaOf(const uint64_t&) { return {{"type", "integer"}, {"minimum", 0}}; }
Schema SchemaOf(const bool&) { return {{"type", "boolean"}}; }
Schema SchemaOf(const std::string&) { return {{"type", "string"}}; }
Schema SchemaOf(const Eigen::Vector2d&) { return Vector(2); }
Schema SchemaOf(const Eigen::Vector3d&) { return Vector(3); }
Schema SchemaOf(const std::map<std::string, double>&) {
  return {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}};
}

Schema SchemaOf(const SystemSettings&) { return {{"type", "object"}, {"additionalProperties", SettingSchema()}}; }

Schema SchemaOf(const SystemChoice&) {
  Schema names{{"enum", Schema::array()}};
  for (const SystemInfo& system : ListSystems()) names["enum"].push_back(system.name);
  const auto foreign = [](Schema schema, const char* key) {
    schema["required"] = {key};
    if (schema["properties"][key]["type"] == "array") schema["properties"][key]["minItems"] = 1;
    return schema;
  };
  Schema plugin = foreign(SchemaOf(PluginChoice()), "plugin");
  plugin["properties"]["name"] = {{"type", "string"}};
  plugin["additionalProperties"] = SettingSchema();
  return {{"anyOf",
           {names, NamedSystemSchema(), plugin, foreign(SchemaOf(ProcessChoice()), "process"),
            foreign(SchemaOf(CommandChoice()), "command")}}};
}

/// Absent numbers come from the preset, so the members' defaults are not shown.
Schema SchemaOf(const GaitChoice& value) {
  internal::SchemaVisitor visitor;
  VisitFields(visitor, const_cast<GaitChoice&>(value));  // the visitor only reads
  for (auto& [key, property] : visitor.properties.items()) {
    if (key != "preset") property.erase("default");
  }
  return {{"type", "object"}, {"properties", visitor.properties}, {"additionalProperties", false}};
}

Schema SchemaOf(const PersonOptions& value) {
  internal::SchemaVisitor visitor;
  VisitFields(visitor, const_cast<PersonOptions&>(value));  // the visitor only reads
  visitor.properties["path"]["minItems"] = 1;
  return {
      {"type", "object"}, {"properties", visitor.properties}, {"required", {"path"}}, {"additionalProperties", false}};
}

Schema SchemaOf(const PairChoice&) { return {{"anyOf", {{{"type", "boolean"}}, SchemaOf(PairOptions())}}}; }

Schema SchemaOf(const RendererChoice&) {
  return {{"type", "string"}, {"pattern", "^(auto|gpu|software|device:[0-9]+)$"}};
}

Schema SchemaOf(const VariationOptions& value) { return PresetBlockSchema(value); }
Schema SchemaOf(const CalibrationErrorOptions& value) { return PresetBlockSchema(value); }

Schema SchemaOf(const Assignments&) { return Reference("assignments"); }
Schema SchemaOf(const Axes&) { return Reference("axes"); }

Schema SchemaOf(const Seeds&) {
  const Schema count{{"type", "integer"}, {"minimum", 1}, {"maximum", 1000000}};
  const Schema list{
      {"type", "array"}, {"items", {{"type", "integer"}, {"minimum", 0}}}, {"minItems", 1}, {"uniqueItems", true}};
  return {{"anyOf", {count, list}}};
}

std::vector<std::string> SchemaKinds() { return {"scenario", "study", "suite", "matrix"}; }

Schema FileSchema(const std::string& kind) {
  Schema body;
  if (kind == "scenario") {
    body = SchemaOf(Scenario());
  } else if (kind == "study") {
    body = ExperimentSchema(FieldsSchema<StudyOptions>(), true);
  } else if (kind == "suite") {
    body = SuiteSchema();
  } else if (kind == "matrix") {
    body = ExperimentSchema(FieldsSchema<MatrixOptions>(), false);
  } else {
    throw BadInput("there is no schema \"" + kind + "\"; there are scenario, study, suite and matrix");
  }
  Schema schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "gaitcam " + kind}};
  schema.update(body);
  return schema;
}

}  // namespace gaitcam
