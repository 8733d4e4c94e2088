/// The runs of a suite, and their comparison with its baseline.

#pragma once

#include <string>
#include <vector>

#include "results/reports/check_report.h"
#include "results/scoring/baseline.h"
#include "scenarios/code/jobs/executor.h"
#include "scenarios/code/jobs/suite.h"

namespace gaitcam {

/// A variant of a suite: as it stands, made worse on purpose, or with another random stream. All variants are measured
/// in one pool.
struct SuiteVariant {
  std::string name;  ///< "" for the suite as it stands.
  std::vector<SuiteEntry> entries;
};

struct MeasuredVariant {
  std::string name;
  std::vector<MeasuredEntry> entries;  ///< In the variant's order.
};

struct SuiteMeasurement {
  std::vector<MeasuredVariant> variants;  ///< In the order given.
  std::string renderer;                   ///< Of these runs; several are joined by " and ".
  int runs = 0, reused = 0;
  double wall_s = 0;
  bool interrupted = false;  ///< If so, `variants` is empty.
};

/// Runs every entry of every variant with every seed; finished runs are used again. A run whose process failed counts
/// as crashed, with the last line of its log as the reason.
/// @throws as ExecuteLocally does.
SuiteMeasurement MeasureSuite(const Suite& suite, const std::vector<SuiteVariant>& variants,
                              const ExecutorOptions& options);

/// The suite with a random stream of the SLAM system that none of its seeds uses: re-runs differ in that alone.
/// @param number tells re-runs apart.
SuiteVariant RerunOf(const Suite& suite, uint64_t number);

/// Compares entries with the baseline's of the same scenario and system; entries without one are left out.
std::vector<EntryVerdict> JudgeAgainst(const Suite& suite, const Baseline& baseline,
                                       const std::vector<MeasuredEntry>& now);

/// Remarks beside the verdict: another renderer, other code that makes frames, entries of the baseline that the suite
/// no longer has.
std::vector<std::string> NotesOn(const Suite& suite, const Baseline& baseline, const std::string& renderer);

/// @param measurement of the suite as it stands and, after it, of re-runs, which become each seed's history.
/// @throws BadInput if a run crashed; TooLittleData if no run of a system on a scenario has scores.
Baseline MakeBaseline(const Suite& suite, const SuiteMeasurement& measurement);

}  // namespace gaitcam
