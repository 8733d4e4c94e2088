#include "models/code/yaml/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"

namespace gaitcam {
namespace {

constexpr int kMaxDepth = 64;          // an alias within its own anchor would nest for ever
constexpr int kMaxValues = 1'000'000;  // aliases of aliases multiply: ten lines may stand for billions of values

OptionOrigin OriginOf(const YAML::Node& node, OptionOrigin origin) {
  const YAML::Mark mark = node.Mark();
  if (!origin.assignment.empty() || mark.is_null()) return origin;
  origin.line = mark.line + 1;
  origin.column = mark.column + 1;
  return origin;
}

/// `origin` names the file or the assignment; the line is the node's.
/// @param values of the whole text so far
OptionValue FromNode(const YAML::Node& node, const OptionOrigin& origin, int& values, int depth = 0) {
  const OptionOrigin here = OriginOf(node, origin);
  if (depth > kMaxDepth) OptionValue::Nothing(here).Fail("nested too deeply");
  if (++values > kMaxValues)
    OptionValue::Nothing(here).Fail("more than a million values, aliases counted as often as they stand");
  if (node.IsScalar()) return OptionValue(node.Scalar(), here);
  if (node.IsSequence()) {
    std::vector<OptionValue> elements;
    for (const YAML::Node& element : node) elements.push_back(FromNode(element, origin, values, depth + 1));
    return OptionValue::List(std::move(elements), here);
  }
  if (!node.IsMap()) return OptionValue::Nothing(here);
  std::vector<OptionValue::Entry> entries;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      OptionValue::Nothing(OriginOf(entry.first, origin)).Fail("expected a plain word as a key");
    entries.push_back(
        {entry.first.Scalar(), OriginOf(entry.first, origin), FromNode(entry.second, origin, values, depth + 1)});
  }
  return OptionValue::Map(std::move(entries), here);
}

/// Where the first value of each document stands.
class DocumentStarts : public YAML::EventHandler {
 public:
  using Mark = YAML::Mark;
  using Anchor = YAML::anchor_t;
  using Style = YAML::EmitterStyle::value;

  void OnDocumentStart(const Mark&) override { begins_ = true; }
  void OnDocumentEnd() override {}
  void OnNull(const Mark& mark, Anchor) override { Note(mark); }
  void OnAlias(const Mark& mark, Anchor) override { Note(mark); }
  void OnScalar(const Mark& mark, const std::string&, Anchor, const std::string&) override { Note(mark); }
  void OnSequenceStart(const Mark& mark, const std::string&, Anchor, Style) override { Note(mark); }
  void OnSequenceEnd() override {}
  void OnMapStart(const Mark& mark, const std::string&, Anchor, Style) override { Note(mark); }
  void OnMapEnd() override {}

  const std::vector<Mark>& marks() const { return marks_; }

 private:
  void Note(const Mark& mark) {
    if (begins_) marks_.push_back(mark);
    begins_ = false;
  }

  bool begins_ = false;
  std::vector<Mark> marks_;
};

/// YAML::LoadAll is no way to ask: where a text begins with a comma it finds documents without end.
void CheckOneDocument(const std::string& text, const OptionOrigin& origin) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStarts starts;
  if (!parser.HandleNextDocument(starts) || !parser.HandleNextDocument(starts) || starts.marks().size() < 2) return;
  OptionOrigin second = origin;
  second.line = starts.marks()[1].line + 1;
  second.column = starts.marks()[1].column + 1;
  const bool stands_still = starts.marks()[1].pos <= starts.marks()[0].pos;
  OptionValue::Nothing(second).Fail(stands_still ? "not valid YAML: no value begins like this"
                                                 : "a second document begins here; expected one in a file");
}

}  // namespace

OptionValue LoadYaml(const std::filesystem::path& file) { return ParseYaml(FileContent(file), file.string()); }

OptionValue ParseYaml(const std::string& text, const std::string& name) {
  OptionOrigin origin;
  origin.file = name;
  try {
    CheckOneDocument(text, origin);
    const YAML::Node document = YAML::Load(text);
    if (!document.IsDefined() || document.IsNull()) return OptionValue::Map({}, origin);
    int values = 0;
    const OptionValue value = FromNode(document, origin, values);
    if (!value.IsMap()) value.Fail("expected a map of keys and values");
    return value;
  } catch (const YAML::ParserException& e) {
    throw BadInput(name + ":" + std::to_string(e.mark.line + 1) + ":" + std::to_string(e.mark.column + 1) +
                   ": not valid YAML: " + e.msg);
  }
}

OptionValue Overlay(const OptionValue& base, const OptionValue& over) {
  if (!base.IsMap() || !over.IsMap()) return over;
  std::vector<OptionValue::Entry> entries;
  for (const OptionValue::Entry& entry : base.entries()) {
    if (!over.Has(entry.key)) entries.push_back(entry);
  }
  for (const OptionValue::Entry& entry : over.entries()) {
    const OptionValue below = base.Has(entry.key) ? base.Child(entry.key) : OptionValue();
    entries.push_back({entry.key, entry.origin, Overlay(below, entry.value)});
  }
  return OptionValue::Map(std::move(entries), over.origin());
}

void SetOption(OptionValue& root, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw BadInput("--set " + assignment + ": expected key=value, for example gait.period_s=0.3");
  }
  OptionOrigin origin;
  origin.file = root.origin().file;  // relative paths are meant from there
  origin.assignment = "--set " + assignment;
  origin.assigned_key = assignment.substr(0, equals);
  try {
    int values = 0;
    root.Set(origin.assigned_key, FromNode(YAML::Load(assignment.substr(equals + 1)), origin, values));
  } catch (const YAML::ParserException& e) {
    throw BadInput("--set " + assignment + ": the value is not valid YAML: " + e.msg);
  }
}

}  // namespace gaitcam
