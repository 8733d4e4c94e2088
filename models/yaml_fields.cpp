#include "models/yaml_fields.h"

#include <fstream>
#include <set>
#include <sstream>

namespace gaitcam {

YamlNode::YamlNode(const YAML::Node& node, std::shared_ptr<std::string> file, std::string path,
                   std::shared_ptr<std::map<std::string, std::string>> overrides)
    : node_(node), file_(std::move(file)), path_(std::move(path)), overrides_(std::move(overrides)) {}

YamlNode YamlNode::LoadFile(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) throw BadInput(file.string() + ": cannot read this file");
  std::ostringstream text;
  text << stream.rdbuf();
  return FromText(text.str(), file.string());
}

YamlNode YamlNode::FromText(const std::string& text, const std::string& name) {
  try {
    YAML::Node root = YAML::Load(text);
    if (root.IsNull()) root = YAML::Node(YAML::NodeType::Map);
    YamlNode node(root, std::make_shared<std::string>(name), "",
                  std::make_shared<std::map<std::string, std::string>>());
    if (!root.IsMap()) node.Fail("expected a map of keys and values");
    return node;
  } catch (const YAML::ParserException& e) {
    throw BadInput(name + ":" + std::to_string(e.mark.line + 1) + ":" + std::to_string(e.mark.column + 1) +
                   ": not valid YAML: " + e.msg);
  }
}

void YamlNode::Set(const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw BadInput("--set " + assignment + ": expected key=value, for example gait.period_s=0.3");
  }
  const std::string path = assignment.substr(0, equals), text = assignment.substr(equals + 1);
  YAML::Node value;
  try {
    value = YAML::Load(text);
  } catch (const YAML::ParserException& e) {
    throw BadInput("--set " + assignment + ": the value is not valid YAML: " + e.msg);
  }
  YAML::Node at = node_;
  std::stringstream keys(path);
  std::string key, next;
  std::getline(keys, key, '.');
  while (std::getline(keys, next, '.')) {
    YAML::Node child = at[key];
    if (!child.IsDefined() || child.IsNull()) {
      child = YAML::Node(YAML::NodeType::Map);
      at[key] = child;
    }
    if (!child.IsMap()) throw BadInput("--set " + assignment + ": " + key + " is not a map and has no key " + next);
    at.reset(child);
    key = next;
  }
  at[key] = value;
  (*overrides_)[path] = text;
}

YamlNode YamlNode::Child(const std::string& key) const {
  return YamlNode(node_[key], file_, path_.empty() ? key : path_ + "." + key, overrides_);
}

YamlNode YamlNode::Element(size_t index) const {
  return YamlNode(node_[index], file_, path_ + "[" + std::to_string(index) + "]", overrides_);
}

void YamlNode::Fail(const std::string& message) const {
  for (auto it = overrides_->rbegin(); it != overrides_->rend(); ++it) {  // the longest key that leads here first
    const auto& [key, text] = *it;
    if (path_.compare(0, key.size(), key) != 0) continue;
    if (path_.size() > key.size() && path_[key.size()] != '.' && path_[key.size()] != '[') continue;
    throw BadInput("--set " + key + "=" + text + ": " + (path_ == key ? "" : path_ + ": ") + message);
  }
  const YAML::Mark mark = node_.Mark();
  std::string place = *file_;
  if (!mark.is_null()) place += ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
  throw BadInput(place + ": " + (path_.empty() ? "" : path_ + ": ") + message);
}

void YamlNode::RejectUnknownKeys(const std::vector<std::string>& known) const {
  if (!node_.IsMap()) Fail("expected a map of keys and values");
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    const YamlNode here(entry.first, file_, path_.empty() ? key : path_ + "." + key, overrides_);
    if (!seen.insert(key).second) here.Fail("this key is given twice");
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string near = NearestWord(key, known);
    std::string all;
    for (const std::string& word : known) all += (all.empty() ? "" : ", ") + word;
    here.Fail("unknown key; " + (near.empty() ? "known here: " + all : "did you mean " + near + "?"));
  }
}

namespace {

template <class T>
void ReadScalar(const YamlNode& node, T& value, const char* expected) {
  if (!node.node().IsScalar()) node.Fail(std::string("expected ") + expected);
  try {
    value = node.node().as<T>();
  } catch (const YAML::Exception&) {
    node.Fail("\"" + node.node().Scalar() + "\" is not " + expected);
  }
}

template <int N>
void ReadVector(const YamlNode& node, Eigen::Matrix<double, N, 1>& value) {
  if (!node.node().IsSequence() || node.node().size() != N) {
    node.Fail("expected a list of " + std::to_string(N) + " numbers");
  }
  for (int i = 0; i < N; ++i) ReadYaml(node.Element(i), value[i]);
}

template <class Vector>
void WriteVector(YAML::Emitter& out, const Vector& value) {
  out << YAML::Flow << YAML::BeginSeq;
  for (int i = 0; i < value.size(); ++i) WriteYaml(out, double(value[i]));
  out << YAML::EndSeq;
}

}  // namespace

void ReadYaml(const YamlNode& node, double& value) { ReadScalar(node, value, "a number"); }
void ReadYaml(const YamlNode& node, int& value) { ReadScalar(node, value, "a whole number"); }
void ReadYaml(const YamlNode& node, uint64_t& value) { ReadScalar(node, value, "a whole number of at least 0"); }
void ReadYaml(const YamlNode& node, bool& value) { ReadScalar(node, value, "true or false"); }
void ReadYaml(const YamlNode& node, std::string& value) { ReadScalar(node, value, "a text"); }
void ReadYaml(const YamlNode& node, Eigen::Vector2d& value) { ReadVector<2>(node, value); }
void ReadYaml(const YamlNode& node, Eigen::Vector3d& value) { ReadVector<3>(node, value); }

void ReadYaml(const YamlNode& node, std::map<std::string, double>& value) {
  if (!node.node().IsMap()) node.Fail("expected a map of names and numbers");
  value.clear();
  for (const auto& entry : node.node()) ReadYaml(node.Child(entry.first.Scalar()), value[entry.first.Scalar()]);
}

void WriteYaml(YAML::Emitter& out, double value) { out << internal::NumberText(value); }
void WriteYaml(YAML::Emitter& out, int value) { out << value; }
void WriteYaml(YAML::Emitter& out, uint64_t value) { out << value; }
void WriteYaml(YAML::Emitter& out, bool value) { out << value; }
void WriteYaml(YAML::Emitter& out, const std::string& value) { out << value; }
void WriteYaml(YAML::Emitter& out, const Eigen::Vector2d& value) { WriteVector(out, value); }
void WriteYaml(YAML::Emitter& out, const Eigen::Vector3d& value) { WriteVector(out, value); }

void WriteYaml(YAML::Emitter& out, const std::map<std::string, double>& value) {
  out << YAML::BeginMap;
  for (const auto& [key, number] : value) {
    out << YAML::Key << key << YAML::Value;
    WriteYaml(out, number);
  }
  out << YAML::EndMap;
}

}  // namespace gaitcam
