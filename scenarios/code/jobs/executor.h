/// Many runs, each in a process of its own: a crash costs one run, and an interrupt only the runs in progress.

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "scenarios/code/jobs/job.h"
#include "scenarios/code/jobs/slurm_pool.h"

namespace gaitcam {

/// One run.
struct WorkItem {
  std::string hash;           ///< HashOf the scenario: names the run's folder.
  std::string frames_hash;    ///< Items with the same one share one rendering.
  std::string scenario_yaml;  ///< Resolved.
  std::string programs;       ///< ProgramsFingerprint: a run finished by other programs is repeated.
  std::string label;          ///< Readable: "exposure_ms=20, sift_vo, seed 3".
  bool is_reusable = true;    ///< False: more than `programs` may decide the result, so that it is always run again.
};

/// @param program the gaitcam executable that carries it out.
WorkItem WorkItemOf(const ResolvedScenario& resolved, const std::string& label,
                    const std::filesystem::path& program = "/proc/self/exe");

struct ExecutorOptions {
  std::filesystem::path runs;  ///< Folder of the runs' folders.
  SequenceCacheOptions cache;
  std::filesystem::path program = "/proc/self/exe";  ///< The gaitcam executable that carries out the runs.
  int jobs = 0;                                      ///< Processes at once; 0: one per core.
  std::string what = "runs";                         ///< Label of the progress line.
  bool quiet = false;
  std::function<bool()> interrupted = [] { return false; };
};

struct ExecutorOutcome {
  int reused = 0, done = 0;
  bool interrupted = false;
  std::map<std::string, std::string> failures;  ///< Hash to the reason.
};

/// Carries out the runs that are not finished yet, in a pool of processes on this machine (pool.h). Items with the same
/// frames wait until one of them has recorded them. Scenarios lie in runs/plan/HASH.yaml, the output of a failed
/// process in runs/log/HASH.log.
/// @throws BadInput if another executor works in the same folder; MissingResource if the machine lacks something that
/// the runs need, at the first run that reports it.
ExecutorOutcome ExecuteLocally(const std::vector<WorkItem>& items, const ExecutorOptions& options);

/// The same on a Slurm cluster (slurm_pool.h), whose files lie in runs/slurm. `options.jobs` is the number of tasks at
/// once; 0: as Slurm likes. An interrupt cancels the job. If an earlier call was killed, its job goes on in the queue:
/// that one is waited for first.
/// @throws as ExecuteLocally; MissingResource also if there is no Slurm, or it does not take the job.
ExecutorOutcome ExecuteOnSlurm(const std::vector<WorkItem>& items, const ExecutorOptions& options,
                               const SlurmOptions& slurm);

/// The run of one process of an executor: reads runs/plan/HASH.yaml. @returns the exit code.
int WorkOn(const std::filesystem::path& runs, const std::string& hash, const SequenceCacheOptions& cache);

}  // namespace gaitcam
