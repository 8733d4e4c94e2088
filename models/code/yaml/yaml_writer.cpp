#include "models/code/yaml/yaml_writer.h"

namespace gaitcam {
namespace {

template <class Vector>
void WriteNumbers(YAML::Emitter& out, const Vector& value) {
  out << YAML::Flow << YAML::BeginSeq;
  for (int i = 0; i < value.size(); ++i) WriteYaml(out, double(value[i]));
  out << YAML::EndSeq;
}

}  // namespace

void WriteYaml(YAML::Emitter& out, double value) { out << internal::NumberText(value); }
void WriteYaml(YAML::Emitter& out, int value) { out << value; }
void WriteYaml(YAML::Emitter& out, uint64_t value) { out << value; }
void WriteYaml(YAML::Emitter& out, bool value) { out << value; }
void WriteYaml(YAML::Emitter& out, const std::string& value) { out << value; }
void WriteYaml(YAML::Emitter& out, const Eigen::Vector2d& value) { WriteNumbers(out, value); }
void WriteYaml(YAML::Emitter& out, const Eigen::Vector3d& value) { WriteNumbers(out, value); }

void WriteYaml(YAML::Emitter& out, const std::map<std::string, double>& value) {
  out << YAML::BeginMap;
  for (const auto& [key, number] : value) {
    out << YAML::Key << key << YAML::Value;
    WriteYaml(out, number);
  }
  out << YAML::EndMap;
}

void WriteYaml(YAML::Emitter& out, const OptionValue& value) {
  switch (value.kind()) {
    case OptionValue::Kind::kNothing: out << YAML::Null; return;
    case OptionValue::Kind::kScalar: out << value.text(); return;
    case OptionValue::Kind::kList:
      out << YAML::BeginSeq;
      for (size_t i = 0; i < value.size(); ++i) WriteYaml(out, value.Element(i));
      out << YAML::EndSeq;
      return;
    case OptionValue::Kind::kMap:
      out << YAML::BeginMap;
      for (const auto& [key, origin, child] : value.entries()) {
        out << YAML::Key << key << YAML::Value;
        WriteYaml(out, child);
      }
      out << YAML::EndMap;
  }
}

}  // namespace gaitcam
