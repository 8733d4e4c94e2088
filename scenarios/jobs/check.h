/// The runs of a suite, and what its baseline says of them.

#pragma once

#include <string>
#include <vector>

#include "results/baseline.h"
#include "results/check_report.h"
#include "scenarios/jobs/executor.h"
#include "scenarios/jobs/suite.h"

namespace gaitcam {

/// One of several ways to run a suite, all measured in one go: as it is, made worse, with another random stream.
struct SuiteVariant {
  std::string name;  ///< "" for the suite as it is.
  std::vector<SuiteEntry> entries;
};

struct MeasuredVariant {
  std::string name;
  std::vector<MeasuredEntry> entries;  ///< As those of the variant.
};

struct SuiteMeasurement {
  std::vector<MeasuredVariant> variants;  ///< In the order given.
  std::string renderer;                   ///< Of these runs; several are joined by " and ".
  int runs = 0, reused = 0;
  double wall_s = 0;
  bool interrupted = false;  ///< Then there are no variants.
};

/// Runs every entry of every variant with every seed, or finds it finished. A run whose process did not end well is
/// measured as crashed, with its last words.
/// @throws as ExecuteLocally does.
SuiteMeasurement MeasureSuite(const Suite& suite, const std::vector<SuiteVariant>& variants,
                              const ExecutorOptions& options);

/// Judges entries against the baseline's of the same scenario and system; those that it does not have are left out.
std::vector<EntryVerdict> JudgeAgainst(const Suite& suite, const Baseline& baseline,
                                       const std::vector<MeasuredEntry>& now);

/// What to know beside the verdict: another renderer, other code that makes frames, entries that nobody checks any
/// more.
std::vector<std::string> NotesOn(const Suite& suite, const Baseline& baseline, const std::string& renderer);

/// @throws BadInput if a run crashed; TooLittleData if no run of a system on a scenario has scores.
Baseline MakeBaseline(const Suite& suite, const SuiteMeasurement& measurement);

}  // namespace gaitcam
