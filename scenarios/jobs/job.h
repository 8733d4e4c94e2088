/// One run as suites and studies want it: frames from the cache, a SLAM system, scores; no film, no report. Its folder
/// is named by the hash of its scenario, so that a finished run is found again.

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "results/score.h"
#include "scenarios/jobs/sequence_cache.h"
#include "scenarios/scenario.h"

namespace gaitcam {

/// What a finished run's folder says.
struct JobRecord {
  std::string hash;        ///< HashOf its scenario.
  std::string status;      ///< Of the walk: "finished", "fell".
  std::string failure;     ///< Why the system stopped working; empty if it did not.
  std::string not_scored;  ///< Why there are no scores; empty if there are.
  std::map<std::string, double>
      scores;  ///< By name; NaN where the run does not determine one. Coverage is there always.
  std::map<std::string, double> timing;  ///< Differs from run to run.
  double blur_median_px = 0;             ///< Median over the frames of each one's median.
  int64_t frames = 0;
  double end_time_s = 0;
  std::string renderer;
};

struct JobOptions {
  std::filesystem::path runs;  ///< The run's folder is runs / hash.
  SequenceCacheOptions cache;
  bool quiet = true;
  std::function<bool()> interrupted = [] { return false; };
};

/// Runs a scenario into runs/HASH: scenario.yaml (resolved), estimate.txt, truth.txt, tracking.csv (what the system
/// said of every frame), scores.json, job.json. The folder appears whole or not at all. What too little was covered
/// for, and a system that crashed, are results as well.
/// @returns false if it was interrupted. @throws BadInput, MissingResource.
bool RunJob(const ResolvedScenario& resolved, const JobOptions& options);

/// A finished run of this very program (and, if its system is an executable, of that very executable).
/// @returns nothing if there is none. @throws BadInput if its files are damaged.
std::optional<JobRecord> FindJob(const std::filesystem::path& runs, const ResolvedScenario& resolved);
std::optional<JobRecord> FindJob(const std::filesystem::path& runs, const std::string& hash,
                                 const std::string& program_fingerprint);

/// What a run depends on besides its scenario: this program, or another one named, and the executable if its system is
/// one.
std::string ProgramsFingerprint(const Scenario& scenario, const std::filesystem::path& program = "/proc/self/exe");

}  // namespace gaitcam
