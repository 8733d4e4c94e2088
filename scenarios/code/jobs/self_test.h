/// The self-test of a gate. Sensitivity: systems made worse on purpose must be reported as regressions. False alarms:
/// re-runs in which only the SLAM system's random stream differs must pass.
///
/// Re-runs are dear, and a hundred say little of a rate of 1 %. But a system's run on one walk knows nothing of its run
/// on another, so any of the re-runs of one seed goes with any of those of the others: many suites are put together
/// from the runs that there are, each run drawn by chance, and judged as well.

#pragma once

#include <string>
#include <vector>

#include "scenarios/code/jobs/check.h"

namespace gaitcam {

struct SelfTestResult {
  struct Worse {
    std::string name;
    std::vector<EntryVerdict> verdicts;
    bool caught = false;
  };
  std::vector<Worse> worse;
  std::vector<std::vector<EntryVerdict>> reruns;
  int resampled = 0;         ///< Suites put together from runs of different re-runs ...
  int resampled_alarms = 0;  ///< ... and those among them that raise an alarm.
  std::vector<EntryVerdict> as_it_is;
  std::string renderer;
  int runs = 0, reused = 0;
  double wall_s = 0;
  bool interrupted = false;

  int Caught() const;
  int FalseAlarms() const;
  /// Those among them that a single seed outside its own history raises (GateRules::seed_margins).
  int AlarmsBySeed() const;
  /// All worse systems are caught, the suite as it stands passes, and at most 1 % of the re-runs raise an alarm.
  bool Passed() const;
};

SelfTestResult RunSelfTest(const Suite& suite, const Baseline& baseline, int reruns, const ExecutorOptions& options);

/// Both rates, a table of the metrics that caught each worse system, and one of the shifts between re-runs.
std::string SelfTestText(const Suite& suite, const SelfTestResult& result);
std::string SelfTestMarkdown(const Suite& suite, const SelfTestResult& result);
std::string SelfTestJson(const SelfTestResult& result);

}  // namespace gaitcam
