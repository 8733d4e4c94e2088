#include "scenarios/code/jobs/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "algorithms/core/errors.h"
#include "scenarios/code/files/versions.h"

namespace gaitcam {
namespace {

using Clock = std::chrono::steady_clock;

/// The items of all variants; equal ones (a variant that changes nothing) are run once.
std::vector<WorkItem> ItemsOf(const Suite& suite, const std::vector<SuiteVariant>& variants) {
  std::vector<WorkItem> items;
  std::set<std::string> seen;
  for (const SuiteVariant& variant : variants) {
    for (const SuiteEntry& entry : variant.entries) {
      for (const uint64_t seed : suite.options.seeds) {
        WorkItem item =
            WorkItemOf(entry.WithSeed(seed), fmt::format("{}, {}, seed {}{}", entry.scenario, entry.system, seed,
                                                         variant.name.empty() ? "" : ", " + variant.name));
        if (seen.insert(item.hash).second) items.push_back(std::move(item));
      }
    }
  }
  return items;
}

void KeepGatingValues(const SuiteEntry& entry, const JobRecord& record, MeasuredRun& run) {
  const auto keep = [&](const std::string& name) {
    const auto score = record.scores.find(name);
    if (score != record.scores.end()) run.values[name] = score->second;
  };
  keep("coverage_ratio");
  for (const GatedMetric& metric : entry.metrics) keep(metric.name);
}

MeasuredRun RunOf(const SuiteEntry& entry, uint64_t seed, const ExecutorOptions& options,
                  const ExecutorOutcome& outcome, std::set<std::string>& renderers) {
  const ResolvedScenario resolved = entry.WithSeed(seed);
  MeasuredRun run;
  run.seed = resolved.scenario.seed;
  run.hash = HashOf(resolved.OnAnyRenderer());
  const auto failure = outcome.failures.find(HashOf(resolved));
  const std::optional<JobRecord> record =
      failure == outcome.failures.end() ? FindJob(options.runs, resolved) : std::nullopt;
  if (!record) {
    run.state = RunState::kCrashed;
    run.reason = failure == outcome.failures.end() ? "the run left nothing behind" : failure->second;
    return run;
  }
  renderers.insert(record->renderer.name);
  KeepGatingValues(entry, *record, run);
  if (!record->failure.empty()) {
    run.state = RunState::kCrashed;
    run.reason = record->failure;
  } else if (!record->not_scored.empty()) {
    run.state = RunState::kNotScored;
    run.reason = record->not_scored;
  }
  return run;
}

/// "turn with mobif_vo_plus, seed 3: reason" for each run in a state.
std::vector<std::string> RunsIn(RunState state, const std::vector<MeasuredEntry>& entries) {
  std::vector<std::string> lines;
  for (const MeasuredEntry& entry : entries) {
    for (const MeasuredRun& run : entry.runs) {
      if (run.state == state)
        lines.push_back(fmt::format("{} with {}, seed {}: {}", entry.scenario, entry.system, run.seed, run.reason));
    }
  }
  return lines;
}

/// @param rerun of the same seeds in the same order.
void AddToHistory(const std::vector<MeasuredRun>& rerun, std::vector<MeasuredRun>& runs) {
  for (size_t k = 0; k < runs.size(); ++k) {
    GAITCAM_ASSERT(rerun[k].seed == runs[k].seed);
    for (const auto& [name, value] : rerun[k].values) runs[k].history[name].push_back(value);
  }
}

}  // namespace

SuiteVariant RerunOf(const Suite& suite, uint64_t number) {
  SuiteVariant variant{fmt::format("re-run {}", number), suite.entries};
  for (SuiteEntry& entry : variant.entries) entry.resolved.scenario.system_seed = 1'000'000 + number;
  return variant;
}

SuiteMeasurement MeasureSuite(const Suite& suite, const std::vector<SuiteVariant>& variants,
                              const ExecutorOptions& options) {
  const Clock::time_point start = Clock::now();
  const std::vector<WorkItem> items = ItemsOf(suite, variants);
  const ExecutorOutcome outcome = ExecuteLocally(items, options);
  SuiteMeasurement measurement;
  measurement.runs = int(items.size());
  measurement.reused = outcome.reused;
  measurement.interrupted = outcome.interrupted;
  if (outcome.interrupted) return measurement;
  std::set<std::string> renderers;
  for (const SuiteVariant& variant : variants) {
    MeasuredVariant measured{variant.name, {}};
    for (const SuiteEntry& entry : variant.entries) {
      MeasuredEntry runs{entry.scenario, entry.system, {}};
      for (const uint64_t seed : suite.options.seeds)
        runs.runs.push_back(RunOf(entry, seed, options, outcome, renderers));
      measured.entries.push_back(std::move(runs));
    }
    measurement.variants.push_back(std::move(measured));
  }
  measurement.renderer = fmt::format("{}", fmt::join(renderers, " and "));
  measurement.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  return measurement;
}

std::vector<EntryVerdict> JudgeAgainst(const Suite& suite, const Baseline& baseline,
                                       const std::vector<MeasuredEntry>& now) {
  std::vector<EntryVerdict> verdicts;
  for (const MeasuredEntry& entry : now) {
    const BaselineEntry* before = baseline.Find(entry.scenario, entry.system);
    const auto is_it = [&](const SuiteEntry& e) { return e.scenario == entry.scenario && e.system == entry.system; };
    const auto gated = std::find_if(suite.entries.begin(), suite.entries.end(), is_it);
    if (before == nullptr || gated == suite.entries.end()) continue;
    verdicts.push_back(JudgeEntry(before->measured, entry, gated->metrics, suite.options.gate));
  }
  return verdicts;
}

std::vector<std::string> NotesOn(const Suite& suite, const Baseline& baseline, const std::string& renderer) {
  std::vector<std::string> notes;
  if (!renderer.empty() && baseline.renderer != renderer)
    notes.push_back(fmt::format("rendered by {}; the baseline by {}", renderer, baseline.renderer));
  if (baseline.frames_fingerprint != FramesFingerprint())
    notes.push_back("the code that makes the frames is not the one that the baseline was measured with");
  for (const BaselineEntry& entry : baseline.entries) {
    const auto is_it = [&](const SuiteEntry& e) {
      return e.scenario == entry.measured.scenario && e.system == entry.measured.system;
    };
    if (std::none_of(suite.entries.begin(), suite.entries.end(), is_it))
      notes.push_back(fmt::format("the baseline has {} with {}, which the suite does not check any more",
                                  entry.measured.scenario, entry.measured.system));
  }
  return notes;
}

Baseline MakeBaseline(const Suite& suite, const SuiteMeasurement& measurement) {
  const std::vector<MeasuredEntry>& measured = measurement.variants.front().entries;
  const std::vector<std::string> crashed = RunsIn(RunState::kCrashed, measured);
  if (!crashed.empty()) {
    throw BadInput(fmt::format("no baseline was written: {} run{} failed; {}", crashed.size(),
                               crashed.size() == 1 ? "" : "s", crashed.front()));
  }
  Baseline baseline{suite.options.name, ProgramVersion(), FramesFingerprint(), measurement.renderer, {}};
  for (size_t i = 0; i < measured.size(); ++i) {
    const auto scored = [](const MeasuredRun& run) { return run.state == RunState::kScored; };
    if (std::none_of(measured[i].runs.begin(), measured[i].runs.end(), scored)) {
      throw TooLittleData(fmt::format("no baseline was written: nothing of {} with {} could be scored; seed {}: {}",
                                      measured[i].scenario, measured[i].system, measured[i].runs.front().seed,
                                      measured[i].runs.front().reason));
    }
    baseline.entries.push_back({measured[i], suite.entries[i].resolved.OnAnyRenderer().ToYaml()});
    for (size_t v = 1; v < measurement.variants.size(); ++v) {
      AddToHistory(measurement.variants[v].entries[i].runs, baseline.entries.back().measured.runs);
    }
  }
  return baseline;
}

}  // namespace gaitcam
