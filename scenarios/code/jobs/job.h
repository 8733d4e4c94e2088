/// One run of a suite or a study: frames from the cache, a SLAM system, scores; no video, no report. The hash of its
/// scenario names its folder, so that a finished run is found again.

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "results/scoring/score.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/jobs/sequence_cache.h"

namespace gaitcam {

/// The record of a finished run: job.json in its folder.
struct JobRecord {
  std::string hash;        ///< HashOf the scenario.
  std::string status;      ///< Of the walk: "finished", "fell".
  std::string failure;     ///< Why the system stopped working; empty if it did not.
  std::string not_scored;  ///< Why there are no scores; empty if there are.
  std::map<std::string, double>
      scores;  ///< By name; NaN where the run does not determine one. Coverage is always present.
  std::map<std::string, double> timing;  ///< Wall times and memory: not repeatable.
  double blur_median_px = 0;             ///< Median over the frames of each frame's median.
  int64_t frames = 0;
  double end_time_s = 0;
  RendererInfo renderer;
};

struct JobOptions {
  std::filesystem::path runs;  ///< The run's folder is runs / hash.
  SequenceCacheOptions cache;
  bool quiet = true;
  std::function<bool()> interrupted = [] { return false; };
};

/// Runs a scenario into runs/HASH: scenario.yaml (resolved), estimate.txt, truth.txt, tracking.csv (the system's
/// status per frame), scores.json, job.json. The folder appears complete or not at all. Too little coverage to score
/// and a crash of the system are results as well.
/// @returns false if it was interrupted. @throws BadInput, MissingResource.
bool RunJob(const ResolvedScenario& resolved, const JobOptions& options);

/// A finished run of this program and of somebody else's system as it is now, both by fingerprint.
/// @returns nothing if there is none. @throws BadInput if its files are damaged.
std::optional<JobRecord> FindJob(const std::filesystem::path& runs, const ResolvedScenario& resolved);
std::optional<JobRecord> FindJob(const std::filesystem::path& runs, const std::string& hash,
                                 const std::string& program_fingerprint);

/// SHA-256 of what a run depends on besides its scenario: this program (or the one named) and the files of somebody
/// else's system.
std::string ProgramsFingerprint(const Scenario& scenario, const std::filesystem::path& program = "/proc/self/exe");

}  // namespace gaitcam
