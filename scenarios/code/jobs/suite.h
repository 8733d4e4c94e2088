/// A suite: systems, scenarios, seeds and metrics of a check.
///
///   scenarios:
///     - {name: turn, scenario: ../quickstart.yaml, set: {duration_s: 7}}
///   systems: [mobif_vo_plus]                   # names, or maps as under `system:` of a scenario
///   seeds: 8
///   metrics:
///     - {name: ate_sim3_rmse_m, margin: 0.001}
///     - {name: rotation_gain, margin: 0.005}   # compared by its distance from 1
///   self_test:
///     - {name: focal length off by 2 %, set: {handicap.focal_factor: 1.02}}
///
/// Every scenario is run with every system and every seed. A scenario that is for other systems, or tells other things,
/// has lists `systems` and `metrics` of its own.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/scoring/baseline.h"
#include "results/scoring/verdict.h"
#include "scenarios/code/files/experiment.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

struct SuiteMetric {
  using DescribedTag = void;
  std::string name;
  double margin = 0, margin_pct = 0;
  bool change = false;
};

template <class Visitor>
void VisitFields(Visitor& visit, SuiteMetric& o) {
  visit("name", o.name, AnyText(), "a score, as `gaitcam run` lists them");
  visit("margin", o.margin, AtLeast(0), "difference that matters, in the score's own unit");
  visit("margin_pct", o.margin_pct, AtLeast(0), "... as a part of the baseline's median; the larger one counts");
  visit("change", o.change, Nested(), "a change in either direction is a regression");
}

struct SuiteScenario {
  using DescribedTag = void;
  std::string name;
  std::string scenario;
  Assignments set;
  std::vector<SystemChoice> systems;
  std::vector<SuiteMetric> metrics;
};

template <class Visitor>
void VisitFields(Visitor& visit, SuiteScenario& o) {
  visit("name", o.name, AnyText(), "as verdicts and baselines call it; defaults to the file's name");
  visit("scenario", o.scenario, AnyText(), "scenario file, relative to this one");
  visit("set", o.set, Nested(), "keys of the scenario that differ");
  visit("systems", o.systems, Nested(), "what tracks here, instead of the suite's systems");
  visit("metrics", o.metrics, Nested(), "what gates here, instead of the suite's metrics");
}

/// A system made worse on purpose, which the gate must report.
struct WorseSystem {
  using DescribedTag = void;
  std::string name;
  Assignments set;
  std::vector<std::string> systems;
  std::vector<std::string> scenarios;
};

template <class Visitor>
void VisitFields(Visitor& visit, WorseSystem& o) {
  visit("name", o.name, AnyText(), "what is wrong with it");
  visit("set", o.set, Nested(), "keys of the scenario that make it worse, such as handicap.focal_factor");
  visit("systems", o.systems, Nested(), "only these of the suite's systems; all unless given");
  visit("scenarios", o.scenarios, Nested(), "only these of the suite's scenarios; all unless given");
}

struct SuiteOptions {
  using DescribedTag = void;
  std::string name;
  std::string description;
  std::vector<SuiteScenario> scenarios;
  std::vector<SystemChoice> systems;
  Seeds seeds;
  std::vector<SuiteMetric> metrics;
  GateRules gate;
  std::vector<WorseSystem> self_test;
};

template <class Visitor>
void VisitFields(Visitor& visit, SuiteOptions& o) {
  visit("name", o.name, AnyText(), "defaults to the file's name");
  visit("description", o.description, AnyText(), "one line for people");
  visit("scenarios", o.scenarios, Nested(), "what is walked");
  visit("systems", o.systems, Nested(), "what tracks: names, or maps as under `system:` of a scenario");
  visit("seeds", o.seeds, Nested(), "how many, counted from 1, or a list of seeds");
  visit("metrics", o.metrics, Nested(), "scores that gate, besides coverage_ratio, which always does");
  visit("gate", o.gate, Nested(), "the rule");
  visit("self_test", o.self_test, Nested(), "systems made worse on purpose, which must be caught");
}

/// One system on one scenario, resolved with the first seed.
struct SuiteEntry {
  std::string scenario, system;
  std::filesystem::path file;
  std::vector<std::string> assignments;
  ResolvedScenario resolved;
  std::vector<GatedMetric> metrics;  ///< Without coverage_ratio.

  ResolvedScenario WithSeed(uint64_t seed) const;
};

struct Suite {
  SuiteOptions options;
  std::filesystem::path file;
  std::vector<SuiteEntry> entries;

  /// The entries that a worse system applies to, with its changes.
  std::vector<SuiteEntry> EntriesOf(const WorseSystem& worse) const;
};

/// Reads a suite by its path, or a shipped one by its name, and resolves every scenario that it names.
/// @throws BadInput with file, line and key; TooLittleData if a regression cannot reach significance with so few
/// seeds.
Suite ReadSuite(const std::string& name_or_path);

/// Where its baseline is: results/baselines/NAME.json for shipped suites, else baselines/NAME.json beside the file.
std::filesystem::path BaselineFileOf(const std::string& name_or_path, const Suite& suite);

/// "camera.exposure_ms is 20, was 12 in the baseline": the keys in which two resolved scenarios differ, at most five.
std::string DifferenceOf(const std::string& yaml_before, const std::string& yaml_now);

/// @throws BadInput naming the baseline's file and what differs, if it is not one of this very suite.
void CheckComparable(const Suite& suite, const Baseline& baseline, const std::filesystem::path& file);

}  // namespace gaitcam
