#include "scenarios/code/files/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "algorithms/core/errors.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// A value as `--set KEY=VALUE` takes it.
std::string OneLine(const OptionValue& value) {
  YAML::Emitter out;
  if (!value.IsScalar()) {
    out.SetSeqFormat(YAML::Flow);
    out.SetMapFormat(YAML::Flow);
  }
  WriteYaml(out, value);
  std::string text = out.c_str();
  if (!value.IsScalar()) std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

size_t CountConditions(const ExperimentOptions& options) {
  if (!options.list.empty()) return options.list.size();
  size_t count = 1;
  for (const auto& [key, values] : options.axes) {
    if (count > kMaxRunsUnasked * 1000) break;  // far too many already
    count *= values.size();
  }
  return count;
}

/// All combinations, the last axis fastest.
std::vector<Assignments> Combinations(const Axes& axes) {
  std::vector<Assignments> all{{}};
  for (const auto& [key, values] : axes) {
    std::vector<Assignments> longer;
    for (const Assignments& before : all) {
      for (const std::string& value : values) {
        longer.push_back(before);
        longer.back().emplace_back(key, value);
      }
    }
    all = std::move(longer);
  }
  return all;
}

void CheckShape(const OptionValue& root, const ExperimentOptions& options, bool yes) {
  if (options.base.empty()) root.Fail("expected the key `base` with the scenario file to start from");
  if (root.Has("axes") && root.Has("list")) root.Child("list").Fail("expected either `axes` or `list`, not both");
  if (options.seeds.empty()) (root.Has("seeds") ? root.Child("seeds") : root).Fail("expected at least one seed");
  const double runs = double(CountConditions(options)) * double(options.seeds.size());
  if (runs <= double(kMaxRunsUnasked) || yes) return;
  root.Fail(fmt::format("{:.0f} runs; more than {} are done only with --yes", runs, kMaxRunsUnasked));
}

/// @throws BadInput at the value within the file that the message is about.
ResolvedScenario Resolve(const OptionValue& root, const ExperimentOptions& options, const Assignments& levels,
                         ModelShelf& shelf) {
  const fs::path base = root.folder() / options.base;
  std::vector<std::string> assignments;
  for (const auto& [key, value] : options.set) assignments.push_back(key + "=" + value);
  for (const auto& [key, value] : levels) assignments.push_back(key + "=" + value);
  assignments.push_back(fmt::format("seed={}", options.seeds.front()));
  try {
    return ReadScenario(base, assignments, &shelf);
  } catch (const BadInput& e) {
    FailAtCondition(root, options, levels, e.what());
  }
}

/// What a message says of a key, if it is about that one: "--set KEY=VALUE: what", or "KEY: what". Empty if not.
std::string AboutKey(const std::string& message, const std::string& key, const std::string& value) {
  const std::string set = "--set " + key + "=" + value + ": ";
  if (message.starts_with(set)) return message.substr(set.size());
  if (message.starts_with(key + ": ")) return message.substr(key.size() + 2);
  return message.starts_with(key + ".") ? message : "";
}

/// Where a level stands: in its axis, or in the entry of the list that has all of them.
OptionValue PlaceOfLevel(const OptionValue& root, const ExperimentOptions& options, const Assignments& levels,
                         size_t i) {
  const auto& [key, value] = levels[i];
  for (const auto& [axis, values] : options.axes) {
    if (axis != key) continue;
    const auto it = std::find(values.begin(), values.end(), value);
    return root.Child("axes").Child(axis).Element(size_t(it - values.begin()));
  }
  for (size_t entry = 0; entry < options.list.size(); ++entry) {
    if (options.list[entry] == levels) return root.Child("list").Element(entry).Child(key);
  }
  return root;
}

}  // namespace

void FailAtCondition(const OptionValue& root, const ExperimentOptions& options, const Assignments& levels,
                     const std::string& message) {
  for (size_t i = 0; i < levels.size(); ++i) {
    const std::string what = AboutKey(message, levels[i].first, levels[i].second);
    if (!what.empty()) PlaceOfLevel(root, options, levels, i).Fail(what);
  }
  for (const auto& [key, value] : options.set) {
    const std::string what = AboutKey(message, key, value);
    if (!what.empty()) root.Child("set").Child(key).Fail(what);
  }
  root.Child("base").Fail(message);
}

void ReadOption(const OptionValue& node, Assignments& value) {
  if (!node.IsMap()) node.Fail("expected a map of a scenario's keys and values");
  value.clear();
  for (const auto& entry : node.entries()) value.emplace_back(entry.key, OneLine(entry.value));
}

void ReadOption(const OptionValue& node, Axes& value) {
  if (node.entries().empty()) node.Fail("expected a map of a scenario's keys and lists of values");
  value.clear();
  for (const auto& entry : node.entries()) {
    const OptionValue list = entry.value.WithPath(node.path() + "." + entry.key);
    if (list.size() == 0) list.Fail("expected a list of at least one value");
    std::vector<std::string> values;
    for (size_t i = 0; i < list.size(); ++i) {
      const std::string text = OneLine(list.Element(i));
      if (std::find(values.begin(), values.end(), text) != values.end()) list.Element(i).Fail(text + " is there twice");
      values.push_back(text);
    }
    for (const auto& [key, others] : value) {
      if (key == entry.key) list.Fail("this axis is given twice");
    }
    value.emplace_back(entry.key, values);
  }
}

void ReadOption(const OptionValue& node, Seeds& value) {
  value.clear();
  if (node.IsScalar()) {
    uint64_t count = 0;
    ReadOption(node, count);
    if (count < 1 || count > 1000000) node.Fail("expected a number of seeds of 1 to 1000000, or a list of seeds");
    for (uint64_t seed = 1; seed <= count; ++seed) value.push_back(seed);
    return;
  }
  ReadOption(node, static_cast<std::vector<uint64_t>&>(value));
  if (value.empty()) node.Fail("expected at least one seed");
  for (size_t i = 0; i < value.size(); ++i) {
    if (std::count(value.begin(), value.begin() + long(i), value[i]) > 0)
      node.Element(i).Fail("this seed is there twice");
  }
}

std::string ShortKey(const std::string& key) { return key.substr(key.rfind('.') + 1); }

std::string Condition::Label() const {
  std::string label;
  for (const auto& [key, value] : levels)
    label += fmt::format("{}{}={}", label.empty() ? "" : ", ", ShortKey(key), value);
  return label;
}

ResolvedScenario Condition::WithSeed(uint64_t seed) const { return resolved.WithSeed(seed); }

Experiment ResolveExperiment(const OptionValue& root, const ExperimentOptions& options, bool yes) {
  CheckShape(root, options, yes);
  Experiment experiment{options, {}, {}};
  if (experiment.options.name.empty()) experiment.options.name = fs::path(root.origin().file).stem().string();
  CheckFileName(root, "name", experiment.options.name);
  const std::vector<Assignments> conditions = options.list.empty() ? Combinations(options.axes) : options.list;
  ModelShelf shelf;
  for (const Assignments& levels : conditions) {
    for (const auto& [key, value] : levels) {
      if (std::find(experiment.keys.begin(), experiment.keys.end(), key) == experiment.keys.end())
        experiment.keys.push_back(key);
    }
    experiment.conditions.push_back({levels, Resolve(root, options, levels, shelf)});
  }
  return experiment;
}

}  // namespace gaitcam
