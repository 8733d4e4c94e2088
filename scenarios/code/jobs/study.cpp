#include "scenarios/code/jobs/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "results/scoring/score_catalogue.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// Keys and values, shortened while unambiguous: `{step_length_m: 0.02, period_s: 0.2}` is "0.02 m, 0.2 s".
std::string ShortValues(const std::vector<std::pair<std::string, std::string>>& values) {
  std::string with_units, with_keys;
  std::set<std::string> units;
  for (const auto& [key, value] : values) {
    const size_t last = key.rfind('_');
    const std::string unit = last == std::string::npos ? "" : key.substr(last + 1);
    const bool known = std::set<std::string>{"m", "s", "ms", "deg", "px"}.count(unit) > 0;
    if (known && units.insert(unit).second) with_units += (with_units.empty() ? "" : ", ") + value + " " + unit;
    with_keys += (with_keys.empty() ? "" : " ") + key + "=" + value;
  }
  return units.size() == values.size() ? with_units : with_keys;
}

/// A level as tables show it: of a map only the keys in which it differs from others, `{name: mobif_vo, ratio: 0.8}` is
/// "mobif_vo ratio=0.8", an executable its name.
std::string ShortLevel(const std::string& text) {
  const YAML::Node node = YAML::Load(text);
  if (node.IsScalar()) return node.Scalar();
  if (!node.IsMap()) return text;
  if (node["command"].IsDefined() && node["command"].IsSequence() && node["command"].size() > 0)
    return node["name"].IsDefined() ? node["name"].Scalar() : fs::path(node["command"][0].Scalar()).stem().string();
  std::string name;
  std::vector<std::pair<std::string, std::string>> rest;
  for (const auto& entry : node) {
    YAML::Emitter value;
    value << YAML::Flow << entry.second;
    const std::string key = entry.first.Scalar();
    if (key == "name" || key == "preset") {
      name = entry.second.Scalar();
    } else {
      rest.emplace_back(key, value.c_str());
    }
  }
  const std::string values = ShortValues(rest);
  return name + (name.empty() || values.empty() ? "" : " ") + values;
}

/// The short texts if they are unique, else the long ones.
std::vector<std::string> LevelNames(const std::vector<std::string>& texts) {
  std::vector<std::string> names;
  for (const std::string& text : texts) names.push_back(ShortLevel(text));
  return std::set(names.begin(), names.end()).size() == names.size() ? names : texts;
}

size_t ReferenceOf(const OptionValue& root, const StudyOptions& options, const std::string& key,
                   const std::vector<std::string>& values) {
  for (const auto& [axis, level] : options.reference) {
    if (axis != key) continue;
    const auto it = std::find(values.begin(), values.end(), level);
    if (it == values.end()) root.Child("reference").Child(key).Fail(level + " is not a level of this axis");
    return size_t(it - values.begin());
  }
  return 0;
}

void AddAxes(const OptionValue& root, Study& study) {
  const StudyOptions& options = study.options;
  for (const auto& [key, values] : options.axes)
    study.table.axes.push_back({key, LevelNames(values), ReferenceOf(root, options, key, values)});
  if (!options.list.empty()) {
    StudyAxis& axis = study.table.axes.emplace_back();
    axis.key = "condition";
    for (const Condition& condition : study.experiment.conditions) {
      const std::string label = condition.Label();
      const auto twin = std::find(axis.levels.begin(), axis.levels.end(), label);
      if (twin != axis.levels.end())
        root.Child("list").Element(axis.levels.size()).Fail("this condition is there twice");
      axis.levels.push_back(label);
    }
  }
  std::vector<std::string> keys;
  for (const StudyAxis& axis : study.table.axes) keys.push_back(axis.key);
  if (root.Has("reference")) {
    if (!options.list.empty()) root.Child("reference").Fail("a list's reference is its first condition");
    RefuseUnknownKeys(root.Child("reference"), keys);
  }
  const std::string by = options.by.empty() ? "system" : options.by;
  const auto it = std::find(keys.begin(), keys.end(), by);
  if (it != keys.end()) study.by = size_t(it - keys.begin());
  if (!options.by.empty() && !study.by) root.Child("by").Fail("\"" + by + "\" is not an axis of this study");
}

const Score& KnownScore(const OptionValue& node, const std::string& name, const std::vector<Score>& known) {
  std::vector<std::string> names;
  for (const Score& score : known) {
    if (score.name == name) return score;
    names.push_back(score.name);
  }
  node.Fail("there is no score \"" + name + "\"; " +
            DidYouMean(name, names, "the scores.json of any run names them all"));
}

void AddMetrics(const OptionValue& root, Study& study) {
  if (study.options.metrics.empty()) root.Child("metrics").Fail("expected at least one score");
  std::vector<Score> known = ScoreCatalogue(study.experiment.conditions.front().resolved.scenario.score);
  for (const Score& score : known) study.table.score_names.push_back(score.name);
  // Scores of maps get a column when a run has them (CollectRuns).
  for (const Score& score : MapScoreCatalogue()) known.push_back(score);
  const std::vector<std::string>& names = study.options.metrics;
  for (size_t i = 0; i < names.size(); ++i) {
    const OptionValue here = root.Has("metrics") ? root.Child("metrics").Element(i) : root;
    study.table.metrics.push_back(KnownScore(here, names[i], known));
    // What a system said live stands beside its last word, asked for or not.
    const std::string live = "live_" + names[i];
    const auto twin = std::find_if(known.begin(), known.end(), [&](const Score& score) { return score.name == live; });
    if (twin == known.end() || std::find(names.begin(), names.end(), live) != names.end()) continue;
    study.table.metrics.push_back(*twin);
  }
}

/// The rows, without results. The conditions of axes are their combinations, the last axis fastest.
void AddRuns(Study& study) {
  const std::vector<Condition>& conditions = study.experiment.conditions;
  study.table.seeds = study.options.seeds.size();
  for (size_t c = 0; c < conditions.size(); ++c) {
    StudyRun run;
    run.levels.resize(study.table.axes.size());
    size_t rest = c;
    for (size_t a = run.levels.size(); a-- > 0;) {
      run.levels[a] = rest % study.table.axes[a].levels.size();
      rest /= study.table.axes[a].levels.size();
    }
    for (const uint64_t seed : study.options.seeds) {
      run.seed = seed;
      study.table.runs.push_back(run);
    }
  }
}

/// Checks that the robot can walk each condition, once for all that share their frames.
void CheckPlans(const OptionValue& root, const Experiment& experiment) {
  std::set<std::string> checked;
  for (const Condition& condition : experiment.conditions) {
    if (!checked.insert(FramesHashOf(condition.resolved)).second) continue;
    try {
      CheckPlan(condition.resolved);
    } catch (const BadInput& e) {
      FailAtCondition(root, experiment.options, condition.levels, e.what());
    }
  }
}

}  // namespace

Study ReadStudy(const fs::path& file, bool yes) {
  const OptionValue root = LoadYaml(file);
  Study study;
  ReadOption(root, study.options);
  if (!root.Has("axes") && !root.Has("list")) root.Fail("expected `axes` or `list`: what the study varies");
  study.experiment = ResolveExperiment(root, study.options, yes);
  study.options.name = study.table.name = study.experiment.options.name;
  study.table.description = study.options.description;
  AddAxes(root, study);
  AddMetrics(root, study);
  AddRuns(study);
  CheckPlans(root, study.experiment);
  study.text = FileContent(file);
  return study;
}

std::vector<WorkItem> ItemsOf(const Study& study) {
  std::vector<WorkItem> items;
  for (const Condition& condition : study.experiment.conditions) {
    for (const uint64_t seed : study.options.seeds)
      items.push_back(WorkItemOf(condition.WithSeed(seed), fmt::format("{}, seed {}", condition.Label(), seed)));
  }
  return items;
}

void CollectRuns(const fs::path& runs, const std::vector<WorkItem>& items,
                 const std::map<std::string, std::string>& failures, StudyTable& table) {
  GAITCAM_ASSERT(items.size() == table.runs.size());
  std::set<std::string> others;
  for (size_t i = 0; i < items.size(); ++i) {
    StudyRun& run = table.runs[i];
    run.hash = items[i].hash;
    const std::optional<JobRecord> record = FindJob(runs, items[i].hash, items[i].programs);
    if (!record) {
      const auto why = failures.find(run.hash);
      run.status = "failed";
      run.failure = why == failures.end() ? "it was not run" : why->second;
      run.blur_median_px = NAN;
      continue;
    }
    run.status = record->status;
    run.failure = record->failure.empty() ? record->not_scored : record->failure;
    run.blur_median_px = record->blur_median_px;
    run.renderer = record->renderer.ToText();
    run.frames = record->frames;
    run.scores = record->scores;
    run.timing = record->timing;
    for (const auto& [name, value] : record->scores) others.insert(name);
  }
  for (const std::string& name : table.score_names) others.erase(name);
  table.score_names.insert(table.score_names.end(), others.begin(), others.end());
}

}  // namespace gaitcam
