/// Described structs (algorithms/core/fields.h) to and from YAML, with errors that point at file, line and column.

#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <charconv>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// A node of a YAML file that knows where it stands.
class YamlNode {
 public:
  /// @throws BadInput if the file cannot be read or is not YAML.
  static YamlNode LoadFile(const std::filesystem::path& file);
  static YamlNode FromText(const std::string& text, const std::string& name);

  /// Replaces or adds the value at a dotted path ("gait.period_s=0.3", "path.points=[[0,0],[1,0]]").
  /// @throws BadInput if `assignment` has no "=", or its path leads through something that is not a map.
  void Set(const std::string& assignment);

  const YAML::Node& node() const { return node_; }
  const std::string& file() const { return *file_; }
  /// The dotted key that leads here; empty at the root.
  const std::string& path() const { return path_; }
  std::filesystem::path folder() const { return std::filesystem::path(*file_).parent_path(); }

  bool Has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined() && !node_[key].IsNull(); }
  YamlNode Child(const std::string& key) const;
  YamlNode Element(size_t index) const;

  /// "file:line:column: key: message", or "--set key=value: message" for a value given on the command line.
  [[noreturn]] void Fail(const std::string& message) const;
  /// @throws BadInput naming the first key of this map that is not in `known`, and the nearest one that is; or a key
  /// twice.
  void RejectUnknownKeys(const std::vector<std::string>& known) const;

 private:
  YamlNode(const YAML::Node& node, std::shared_ptr<std::string> file, std::string path,
           std::shared_ptr<std::map<std::string, std::string>> overrides);

  YAML::Node node_;
  std::shared_ptr<std::string> file_;
  std::string path_;
  std::shared_ptr<std::map<std::string, std::string>> overrides_;  ///< Dotted key to the text it was set to.
};

/// Reads one value; overloads exist for the member types that described structs use. A struct with rules of its own
/// provides `void ReadYaml(const YamlNode&, T&)` in its namespace.
void ReadYaml(const YamlNode& node, double& value);
void ReadYaml(const YamlNode& node, int& value);
void ReadYaml(const YamlNode& node, uint64_t& value);
void ReadYaml(const YamlNode& node, bool& value);
void ReadYaml(const YamlNode& node, std::string& value);
void ReadYaml(const YamlNode& node, Eigen::Vector2d& value);
void ReadYaml(const YamlNode& node, Eigen::Vector3d& value);
void ReadYaml(const YamlNode& node, std::map<std::string, double>& value);
template <class T>
void ReadYaml(const YamlNode& node, std::vector<T>& value);
template <class T>
void ReadYaml(const YamlNode& node, std::optional<T>& value);
template <Described T>
void ReadYaml(const YamlNode& node, T& value);

void WriteYaml(YAML::Emitter& out, double value);
void WriteYaml(YAML::Emitter& out, int value);
void WriteYaml(YAML::Emitter& out, uint64_t value);
void WriteYaml(YAML::Emitter& out, bool value);
void WriteYaml(YAML::Emitter& out, const std::string& value);
void WriteYaml(YAML::Emitter& out, const Eigen::Vector2d& value);
void WriteYaml(YAML::Emitter& out, const Eigen::Vector3d& value);
void WriteYaml(YAML::Emitter& out, const std::map<std::string, double>& value);
template <class T>
void WriteYaml(YAML::Emitter& out, const std::vector<T>& value);
template <class T>
void WriteYaml(YAML::Emitter& out, const std::optional<T>& value);
template <Described T>
void WriteYaml(YAML::Emitter& out, const T& value);

namespace internal {

/// Lists the keys of a described struct.
struct KeyCollector {
  std::vector<std::string> keys;
  template <class T, class Limits>
  void operator()(std::string_view key, T&, const Limits&, std::string_view) {
    keys.emplace_back(key);
  }
};

/// Sets the members whose keys are present, and checks each against its limits while its place in the file is known.
struct YamlFieldReader {
  const YamlNode& map;

  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits& limits, std::string_view) {
    const std::string name(key);
    if (!map.Has(name)) return;
    const YamlNode child = map.Child(name);
    ReadYaml(child, member);
    if constexpr (!std::is_same_v<Limits, Nested>) {
      if constexpr (std::is_same_v<T, std::string>) {
        if (limits.Contains(member)) return;
        const std::string near = NearestWord(member, limits.words);
        child.Fail("\"" + member + "\" is not permitted; expected " + limits.ToText() +
                   (near.empty() ? "" : " (did you mean " + near + "?)"));
      } else if (!limits.Contains(double(member))) {
        child.Fail(NumberText(double(member)) + " is not permitted; expected " + limits.ToText());
      }
    }
  }
};

/// A list of described structs that is empty says nothing, nor does an absent one, so it is left out.
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

/// The keys that a described struct reads.
template <Described T>
std::vector<std::string> FieldKeys() {
  internal::KeyCollector collector;
  T value;
  VisitFields(collector, value);
  return collector.keys;
}

template <Described T>
void ReadYaml(const YamlNode& node, T& value) {
  node.RejectUnknownKeys(FieldKeys<T>());
  internal::YamlFieldReader reader{node};
  VisitFields(reader, value);
}

template <class T>
void ReadYaml(const YamlNode& node, std::vector<T>& value) {
  if (!node.node().IsSequence()) node.Fail("expected a list");
  value.assign(node.node().size(), T{});
  for (size_t i = 0; i < value.size(); ++i) ReadYaml(node.Element(i), value[i]);
}

template <class T>
void ReadYaml(const YamlNode& node, std::optional<T>& value) {
  value.emplace();
  ReadYaml(node, *value);
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
