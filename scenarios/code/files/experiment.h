/// Many scenarios from one: a base file, axes of keys and values, and seeds. Studies and matrices of recordings are
/// such files.
///
///   base: ../lab_loop.yaml
///   set: {duration_s: 12}                       # for all of them
///   axes:
///     camera.exposure_ms: [0, 10, 20, 33]       # any key of a scenario
///     system: [sift_vo, mobif_vo_plus]
///   seeds: 10                                   # 1 to 10; or a list
///
/// All combinations of the axes are the conditions; the first axis changes slowest. Instead of axes, `list` names the
/// conditions one by one, each a map of keys and values. A value that is a map replaces the base's whole; what `set`
/// gave a part of it would be lost, which is an error.

#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/code/files/scenario.h"

namespace gaitcam {

/// Keys of a scenario and their values as YAML text on one line, in the order of the file.
struct Assignments : std::vector<std::pair<std::string, std::string>> {
  using vector::vector;
};
/// Keys and the values that each takes.
struct Axes : std::vector<std::pair<std::string, std::vector<std::string>>> {
  using vector::vector;
};
/// A number N, meaning 1 to N, or a list of them.
struct Seeds : std::vector<uint64_t> {
  using vector::vector;
};

void ReadOption(const OptionValue& node, Assignments& value);
void ReadOption(const OptionValue& node, Axes& value);
void ReadOption(const OptionValue& node, Seeds& value);

/// What every such file has; a study and a matrix add keys of their own.
struct ExperimentOptions {
  using DescribedTag = void;
  std::string name;
  std::string description;
  std::string base;
  Assignments set;
  Axes axes;
  std::vector<Assignments> list;
  Seeds seeds{1};
};

template <class Visitor>
void VisitFields(Visitor& visit, ExperimentOptions& o) {
  visit("name", o.name, AnyText(), "defaults to the file's name");
  visit("description", o.description, AnyText(), "one line for people");
  visit("base", o.base, AnyText(), "scenario file, relative to this one");
  visit("set", o.set, Nested(), "keys of the scenario that differ from the base, for all conditions");
  visit("axes", o.axes, Nested(), "keys of the scenario and the values that each takes; all combinations are run");
  visit("list", o.list, Nested(), "the conditions one by one, instead of axes");
  visit("seeds", o.seeds, Nested(), "how many, counted from 1, or a list of seeds");
}

/// One combination, resolved with the first seed.
struct Condition {
  Assignments levels;  ///< One per axis; or the entries of the list.
  ResolvedScenario resolved;

  /// "exposure_ms=20, system=sift_vo": the last part of each key.
  std::string Label() const;
  ResolvedScenario WithSeed(uint64_t seed) const;
};

struct Experiment {
  ExperimentOptions options;
  std::vector<std::string> keys;  ///< Of the axes; of a list, all that occur in it.
  std::vector<Condition> conditions;

  size_t runs() const { return conditions.size() * options.seeds.size(); }
};

/// Runs that an experiment may have without being asked for again.
constexpr size_t kMaxRunsUnasked = 100000;

/// Resolves every condition. `root` is the file, already read into `options`.
/// @throws BadInput with file, line and key: no base, an axis without values or twice the same one, a condition that no
/// scenario can be made of, both or neither of axes and list, more than kMaxRunsUnasked runs without `yes`.
Experiment ResolveExperiment(const OptionValue& root, const ExperimentOptions& options, bool yes);

/// Says what is wrong with a condition where the file gives it: at the level, the key of `set`, or the base that the
/// message names ("--set KEY=VALUE: ...", "KEY: ...").
[[noreturn]] void FailAtCondition(const OptionValue& root, const ExperimentOptions& options, const Assignments& levels,
                                  const std::string& message);

/// "camera.exposure_ms" -> "exposure_ms".
std::string ShortKey(const std::string& key);

}  // namespace gaitcam
