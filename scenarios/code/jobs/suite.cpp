#include "scenarios/code/jobs/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "results/scoring/score_catalogue.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

bool IsPath(const std::string& name_or_path) {
  return name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
}

/// The shipped suite of this name. @throws BadInput naming those that there are.
fs::path ShippedSuite(const std::string& name) {
  const fs::path folder = DataFolder() / "scenarios/suites";
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& item : fs::directory_iterator(folder, error)) {
    if (item.path().extension() == ".yaml") names.push_back(item.path().stem().string());
  }
  if (std::find(names.begin(), names.end(), name) != names.end()) return folder / (name + ".yaml");
  std::sort(names.begin(), names.end());
  throw BadInput(
      fmt::format("there is no suite \"{}\"; there are {}, and a file of yours is named by a path (./{}.yaml)", name,
                  fmt::join(names, ", "), name));
}

std::string OneLine(const SystemChoice& system) {
  YAML::Emitter out;
  out.SetSeqFormat(YAML::Flow);
  out.SetMapFormat(YAML::Flow);
  WriteYaml(out, system);
  std::string text = out.c_str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// The label of each system: its name, or its name with all settings where two have the same name.
/// @param node has the list `systems`.
std::vector<std::string> LabelsOf(const OptionValue& node, const std::vector<SystemChoice>& systems) {
  std::vector<std::string> labels;
  for (size_t i = 0; i < systems.size(); ++i) {
    const auto same_name = [&](const SystemChoice& other) { return other.name == systems[i].name; };
    const bool unique = std::count_if(systems.begin(), systems.end(), same_name) == 1;
    labels.push_back(unique ? systems[i].name : OneLine(systems[i]));
    if (std::count(labels.begin(), labels.end(), labels.back()) > 1)
      node.Child("systems").Element(i).Fail("this system is there twice");
  }
  return labels;
}

void CheckLists(const OptionValue& root, const SuiteOptions& options) {
  const auto need = [&](const char* key, bool empty, const char* what) {
    if (empty) (root.Has(key) ? root.Child(key) : root).Fail(std::string("expected at least one ") + what);
  };
  need("scenarios", options.scenarios.empty(), "scenario under `scenarios`");
  const auto all_have = [&](auto list) {
    return std::none_of(options.scenarios.begin(), options.scenarios.end(),
                        [&](const SuiteScenario& scenario) { return (scenario.*list).empty(); });
  };
  need("systems", options.systems.empty() && !all_have(&SuiteScenario::systems), "system under `systems`");
  need("seeds", options.seeds.empty(), "seed: the key `seeds`, such as 8");
  need("metrics", options.metrics.empty() && !all_have(&SuiteScenario::metrics), "metric under `metrics`");
  std::set<std::string> names;
  for (size_t i = 0; i < options.scenarios.size(); ++i) {
    const SuiteScenario& scenario = options.scenarios[i];
    const OptionValue node = root.Child("scenarios").Element(i);
    if (scenario.scenario.empty()) node.Fail("expected the key `scenario` with a file");
    if (!names.insert(scenario.name).second)
      node.Fail("two scenarios are called " + scenario.name + "; give them a `name`");
  }
  names.clear();
  for (size_t i = 0; i < options.self_test.size(); ++i) {
    const OptionValue node = root.Child("self_test").Element(i);
    if (options.self_test[i].name.empty()) node.Fail("expected the key `name`: what is wrong with this system");
    if (options.self_test[i].set.empty()) node.Fail("expected the key `set`: what makes this system worse");
    if (!names.insert(options.self_test[i].name).second) node.Fail("this name is there twice");
  }
}

SuiteEntry ResolveEntry(const fs::path& file, std::vector<std::string> assignments, const SuiteEntry& names,
                        ModelShelf& shelf) {
  SuiteEntry entry = names;
  entry.file = file;
  entry.resolved = ReadScenario(file, assignments, &shelf);
  entry.assignments = std::move(assignments);
  return entry;
}

/// One scenario with its own systems, or the suite's.
void ResolveSystems(const OptionValue& root, size_t scenario_index, ModelShelf& shelf, Suite& suite) {
  const SuiteScenario& scenario = suite.options.scenarios[scenario_index];
  const OptionValue here = root.Child("scenarios").Element(scenario_index);
  const bool own = !scenario.systems.empty();
  const std::vector<SystemChoice>& systems = own ? scenario.systems : suite.options.systems;
  const std::vector<std::string> labels = LabelsOf(own ? here : root, systems);
  for (size_t k = 0; k < systems.size(); ++k) {
    std::vector<std::string> assignments;
    for (const auto& [key, value] : scenario.set) assignments.push_back(key + "=" + value);
    assignments.push_back("system=" + OneLine(systems[k]));
    assignments.push_back(fmt::format("seed={}", suite.options.seeds.front()));
    try {
      suite.entries.push_back(ResolveEntry((root.folder() / scenario.scenario).lexically_normal(), assignments,
                                           {scenario.name, labels[k], {}, {}, {}, {}}, shelf));
    } catch (const BadInput& e) {
      here.Fail(e.what());
    }
  }
}

void ResolveEntries(const OptionValue& root, Suite& suite) {
  ModelShelf shelf;
  for (size_t i = 0; i < suite.options.scenarios.size(); ++i) ResolveSystems(root, i, shelf, suite);
}

/// Unit and direction of the score of this name. @param node of the metric.
GatedMetric ResolveMetric(const OptionValue& node, const SuiteMetric& metric, const SuiteEntry& entry) {
  if (metric.name.empty()) node.Fail("expected the key `name` with a score");
  if (metric.name == "coverage_ratio")
    node.Fail("coverage_ratio always gates; its margin is `coverage_margin` under `gate`");
  std::vector<Score> catalogue = ScoreCatalogue(entry.resolved.scenario.score);
  // A system that makes no map has none of these: its metric is then undecided, which never passes.
  for (const Score& score : MapScoreCatalogue()) catalogue.push_back(score);
  std::vector<std::string> names;
  for (const Score& score : catalogue) names.push_back(score.name);
  const auto there = std::find(names.begin(), names.end(), metric.name);
  if (there == names.end()) {
    node.Fail(fmt::format("scenario {} has no score \"{}\"; {}", entry.scenario, metric.name,
                          DidYouMean(metric.name, names, "the scores.json of any run names them all")));
  }
  const Score& score = catalogue[size_t(there - names.begin())];
  if (score.better == Better::kNeither) node.Fail(metric.name + " gets neither better nor worse; it cannot gate");
  return {metric.name, score.unit, score.better, metric.margin, metric.margin_pct, metric.change};
}

/// @param node has the list `metrics`.
void ResolveMetrics(const OptionValue& node, const std::vector<SuiteMetric>& metrics, SuiteEntry& entry) {
  for (size_t i = 0; i < metrics.size(); ++i) {
    const OptionValue here = node.Child("metrics").Element(i);
    entry.metrics.push_back(ResolveMetric(here, metrics[i], entry));
    for (size_t k = 0; k < i; ++k) {
      if (metrics[k].name == metrics[i].name) here.Fail("this metric is there twice");
    }
  }
}

void ResolveMetrics(const OptionValue& root, Suite& suite) {
  const std::vector<SuiteScenario>& scenarios = suite.options.scenarios;
  for (SuiteEntry& entry : suite.entries) {
    const auto is_it = [&](const SuiteScenario& scenario) { return scenario.name == entry.scenario; };
    const auto scenario = std::find_if(scenarios.begin(), scenarios.end(), is_it);
    if (scenario->metrics.empty()) {
      ResolveMetrics(root, suite.options.metrics, entry);
    } else {
      ResolveMetrics(root.Child("scenarios").Element(size_t(scenario - scenarios.begin())), scenario->metrics, entry);
    }
  }
}

/// Resolves the worse systems when the suite is read, so that an error in them is not found only by the self-test.
void CheckWorse(const OptionValue& root, const Suite& suite) {
  for (size_t i = 0; i < suite.options.self_test.size(); ++i) {
    const OptionValue node = root.Child("self_test").Element(i);
    const WorseSystem& worse = suite.options.self_test[i];
    for (const std::string& system : worse.systems) {
      const auto is_it = [&](const SuiteEntry& entry) { return entry.system == system; };
      if (std::none_of(suite.entries.begin(), suite.entries.end(), is_it))
        node.Child("systems").Fail("the suite has no system " + system);
    }
    for (const std::string& scenario : worse.scenarios) {
      const auto is_it = [&](const SuiteEntry& entry) { return entry.scenario == scenario; };
      if (std::none_of(suite.entries.begin(), suite.entries.end(), is_it))
        node.Child("scenarios").Fail("the suite has no scenario " + scenario);
    }
    try {
      suite.EntriesOf(worse);
    } catch (const BadInput& e) {
      node.Fail(e.what());
    }
  }
}

void CheckSeeds(const Suite& suite) {
  const GateRules& gate = suite.options.gate;
  const int seeds = int(suite.options.seeds.size());
  const int needed = std::max(gate.min_pairs, FewestPairs(gate.alpha));
  if (seeds >= needed) return;
  throw TooLittleData(fmt::format("{}: {} seed{} can never show a regression; at alpha {:g} at least {} are needed",
                                  suite.file.string(), seeds, seeds == 1 ? "" : "s", gate.alpha, needed));
}

/// Dotted keys and their values as text.
void Flatten(const YAML::Node& node, const std::string& path, std::map<std::string, std::string>& flat) {
  if (!node.IsMap()) {
    YAML::Emitter out;
    out.SetSeqFormat(YAML::Flow);
    out << node;
    flat[path] = out.c_str();
    return;
  }
  for (const auto& item : node)
    Flatten(item.second, path.empty() ? item.first.Scalar() : path + "." + item.first.Scalar(), flat);
}

[[noreturn]] void Incomparable(const fs::path& file, const std::string& what) {
  throw BadInput(fmt::format("{}: {}; --update writes a new baseline", file.string(), what));
}

void CheckEntryComparable(const Suite& suite, const SuiteEntry& entry, const BaselineEntry& before,
                          const fs::path& file) {
  const std::string name = entry.scenario + " with " + entry.system;
  for (const uint64_t seed : suite.options.seeds) {
    const auto& runs = before.measured.runs;
    const auto run = std::find_if(runs.begin(), runs.end(), [&](const MeasuredRun& r) { return r.seed == seed; });
    if (run == runs.end()) Incomparable(file, fmt::format("it has no seed {} of {}", seed, name));
    const ResolvedScenario resolved = entry.WithSeed(seed).OnAnyRenderer();
    if (run->hash == HashOf(resolved)) continue;
    const ResolvedScenario first = entry.WithSeed(runs.front().seed).OnAnyRenderer();
    const std::string difference = DifferenceOf(before.resolved, first.ToYaml());
    Incomparable(file, fmt::format("{} is another scenario by now: {}", name,
                                   difference.empty() ? "the files of its robot or scene have changed" : difference));
  }
  const auto has_value_of = [&](const std::string& metric) {
    const auto& runs = before.measured.runs;
    const auto has = [&](const MeasuredRun& run) {
      return run.state != RunState::kScored || run.values.count(metric) > 0;
    };
    return std::all_of(runs.begin(), runs.end(), has);
  };
  // A system that gives no poses, as one of places, has no coverage in any run.
  const auto& runs = before.measured.runs;
  const bool poses = std::any_of(runs.begin(), runs.end(),
                                 [](const MeasuredRun& run) { return run.values.count("coverage_ratio") > 0; });
  if (poses && !has_value_of("coverage_ratio")) Incomparable(file, "it has no coverage_ratio of some runs of " + name);
  for (const GatedMetric& metric : entry.metrics) {
    if (!has_value_of(metric.name)) Incomparable(file, fmt::format("it has no {} of {}", metric.name, name));
  }
}

}  // namespace

ResolvedScenario SuiteEntry::WithSeed(uint64_t seed) const { return resolved.WithSeed(seed); }

std::vector<SuiteEntry> Suite::EntriesOf(const WorseSystem& worse) const {
  std::vector<SuiteEntry> made;
  ModelShelf shelf;  // robots and scenes are those that the suite was read with
  for (const SuiteEntry& entry : entries) {
    shelf.robots.emplace(entry.resolved.scenario.robot, entry.resolved.robot);
    const Scenario& scenario = entry.resolved.scenario;
    const bool as_shipped =
        SaysNothing(scenario.variation) && scenario.people.empty() && !scenario.crowd && !entry.resolved.scene.crowd;
    if (as_shipped) shelf.scenes.emplace(scenario.scene, entry.resolved.scene);
  }
  const auto is_among = [](const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const SuiteEntry& entry : entries) {
    if (!is_among(worse.systems, entry.system) || !is_among(worse.scenarios, entry.scenario)) continue;
    std::vector<std::string> assignments = entry.assignments;
    for (const auto& [key, value] : worse.set) assignments.push_back(key + "=" + value);
    made.push_back(ResolveEntry(entry.file, assignments, entry, shelf));
  }
  return made;
}

Suite ReadSuite(const std::string& name_or_path) {
  Suite suite;
  suite.file = IsPath(name_or_path) ? fs::path(name_or_path) : ShippedSuite(name_or_path);
  const OptionValue root = LoadYaml(suite.file);
  ReadOption(root, suite.options);
  if (suite.options.name.empty()) suite.options.name = suite.file.stem().string();
  CheckFileName(root, "name", suite.options.name);
  for (SuiteScenario& scenario : suite.options.scenarios) {
    if (scenario.name.empty()) scenario.name = fs::path(scenario.scenario).stem().string();
  }
  CheckLists(root, suite.options);
  ResolveEntries(root, suite);
  ResolveMetrics(root, suite);
  CheckWorse(root, suite);
  CheckSeeds(suite);
  return suite;
}

fs::path BaselineFileOf(const std::string& name_or_path, const Suite& suite) {
  const std::string name = suite.options.name + ".json";
  return IsPath(name_or_path) ? suite.file.parent_path() / "baselines" / name
                              : DataFolder() / "results/baselines" / name;
}

std::string DifferenceOf(const std::string& yaml_before, const std::string& yaml_now) {
  std::map<std::string, std::string> before, now;
  try {
    Flatten(YAML::Load(yaml_before), "", before);
    Flatten(YAML::Load(yaml_now), "", now);
  } catch (const YAML::Exception&) {
    return "";
  }
  std::set<std::string> keys;
  for (const auto& side : {before, now}) {
    for (const auto& [key, value] : side) keys.insert(key);
  }
  std::vector<std::string> words;
  for (const std::string& key : keys) {
    const auto a = before.find(key), b = now.find(key);
    if (a != before.end() && b != now.end() && a->second == b->second) continue;
    words.push_back(fmt::format("{} is {}, was {} in the baseline", key, b == now.end() ? "absent" : b->second,
                                a == before.end() ? "absent" : a->second));
  }
  const size_t all = words.size();
  words.resize(std::min<size_t>(all, 5));
  if (all > words.size()) words.push_back(fmt::format("and {} more keys", all - words.size()));
  return fmt::format("{}", fmt::join(words, "; "));
}

void CheckComparable(const Suite& suite, const Baseline& baseline, const fs::path& file) {
  for (const SuiteEntry& entry : suite.entries) {
    const BaselineEntry* before = baseline.Find(entry.scenario, entry.system);
    if (before == nullptr) Incomparable(file, "it has nothing of " + entry.scenario + " with " + entry.system);
    CheckEntryComparable(suite, entry, *before, file);
  }
}

}  // namespace gaitcam
